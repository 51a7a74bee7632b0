// States how fast a user wants one hand to move its tool.
#pragma once
#include <cstdint>

namespace crn
{

struct HandSpeed {
    std::int64_t push_um_per_s = 0, turn_counts_per_s = 0; // + into the patient; + to the right
    bool operator==(const HandSpeed &) const = default;
};

} // namespace crn
