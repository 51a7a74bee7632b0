// Holds the memory of one simulation of the core for a double-precision program, and converts the core's
// number formats.
#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>
extern "C" {
#include "firmware/core/core.h"
}

namespace vcsim3
{

inline double from_q(std::int32_t value, int bits)
{
    return std::ldexp(value, -bits);
}

// Rounds `value` to the nearest number in the Q30 format; |value| must be below 2.
inline std::int32_t to_q30(double value)
{
    return static_cast<std::int32_t>(std::lround(std::ldexp(value, 30)));
}

// Holds the core's model and state in aligned memory, and the input and output of one tick. A CoreBlocks
// object cannot be copied or moved.
struct CoreBlocks {
    std::vector<std::max_align_t> model_memory, state_memory;
    crn_model *model = nullptr;
    crn_state *state = nullptr;
    crn_input input{};
    crn_output output{};

    CoreBlocks()
        : model_memory(crn_model_size() / sizeof(std::max_align_t) + 1),
          state_memory(crn_state_size() / sizeof(std::max_align_t) + 1),
          model(reinterpret_cast<crn_model *>(model_memory.data())),
          state(reinterpret_cast<crn_state *>(state_memory.data()))
    {
    }
    CoreBlocks(const CoreBlocks &) = delete;
    CoreBlocks &operator=(const CoreBlocks &) = delete;
};

} // namespace vcsim3
