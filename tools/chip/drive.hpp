// Hands that look for dear ticks: they push the tools far in, then jerk and turn each of them by chance. One
// seed gives the same hands on every machine.
#pragma once
#include "shared/wire/wire.h"
#include <cstdint>
#include <random>

namespace chip
{

class Drive
{
  public:
    // `tools` hands; with a balloon, the inflator moves too.
    Drive(std::uint32_t seed, std::uint32_t tools, bool has_balloon);
    const crn_wire_tick_input &next();

  private:
    struct Motion {
        std::uint32_t ticks_left = 0;
        std::int32_t feed = 0, turn = 0; // counts in a tick
    };
    std::int32_t between(std::int32_t low, std::int32_t high);
    void choose(std::uint32_t tool, bool pushes);

    std::mt19937 engine_;
    std::uint32_t tools_, tick_ = 0, push_ticks_;
    bool has_balloon_;
    Motion motions_[CRN_WIRE_TOOL_MAX];
    crn_wire_tick_input input_{};
};

} // namespace chip
