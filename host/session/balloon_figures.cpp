#include "host/session/balloon_figures.hpp"
#include <algorithm>

namespace crn
{

BalloonFigures::Peak &BalloonFigures::peak_of(const LineNumbers &line)
{
    if (!peaks.empty() && peaks.back().line == line) return peaks.back();
    const auto known =
        std::find_if(peaks.begin(), peaks.end(), [&](const Peak &peak) { return peak.line == line; });
    if (known != peaks.end()) return *known;
    peaks.push_back({line});
    return peaks.back();
}

void BalloonFigures::take(const crn_wire_tick_state &state)
{
    if (state.balloon_diameter_max_um == 0) return;
    is_there = true;
    const double wall_N = state.balloon_wall_mN * 1e-3;
    Peak &peak = peak_of(line_of(state));
    if (state.balloon_kPa > peak.pressure_kPa) {
        peak.pressure_kPa = state.balloon_kPa;
        peak.tick = state.tick;
    }
    diameter_max_mm = std::max(diameter_max_mm, state.balloon_diameter_max_um * 1e-3);
    wall_max_N = std::max(wall_max_N, wall_N);
    if (state.balloon_bits != 0 && !burst_tick) burst_tick = state.tick;
    const bool is_up = state.balloon_kPa >= up_kPa;
    inflations += is_up && up_since_ == 0;
    up_since_ = is_up ? up_since_ + 1 : 0;
    ticks_up += is_up;
    ticks_up_longest = std::max(ticks_up_longest, up_since_);
    if (state.tick % sample_every_ticks != 0) return;
    series.push_back({state.tick, static_cast<float>(state.balloon_kPa),
                      static_cast<float>(state.balloon_diameter_max_um * 1e-3),
                      static_cast<float>(state.balloon_diameter_min_um * 1e-3), static_cast<float>(wall_N)});
}

} // namespace crn
