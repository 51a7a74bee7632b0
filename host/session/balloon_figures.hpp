// Collects measurements of a balloon in a session: pressure, diameter, contact force and duration. The class
// BalloonFigures also stores how these measurements change over time, for the curves of the report. The
// measurements come from the state of every tick, so they are equal in a run, in FREE_RUN and in a replay.
#pragma once
#include "host/model/tool_line.hpp"
#include "shared/wire/wire.h"
#include <cstdint>
#include <optional>
#include <vector>

namespace crn
{

struct BalloonSample {
    std::uint32_t tick = 0;
    float pressure_kPa = 0, diameter_max_mm = 0, diameter_min_mm = 0, wall_N = 0;
};

struct BalloonFigures {
    static constexpr std::uint32_t sample_every_ticks = 40;
    static constexpr std::uint32_t up_kPa = 50; // from this pressure on the balloon is unfolded
                                                // (docs/balloon.md)

    bool is_there = false; // whether some tool has a balloon
    // Holds the highest balloon pressure while the same tools were in use; a replacement of tools may have
    // brought another balloon.
    struct Peak {
        LineNumbers line;
        std::uint32_t pressure_kPa = 0, tick = 0;
    };
    std::vector<Peak> peaks; // one for each line on which there was a balloon
    double diameter_max_mm = 0.0, wall_max_N = 0.0;
    std::uint32_t ticks_up = 0, ticks_up_longest = 0, inflations = 0;
    std::optional<std::uint32_t> burst_tick;
    std::vector<BalloonSample> series; // samples at multiples of sample_every_ticks, while there is a balloon

    void take(const crn_wire_tick_state &state);

  private:
    Peak &peak_of(const LineNumbers &line);
    std::uint32_t up_since_ = 0; // ticks
};

} // namespace crn
