#include "host/effects/beat.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

// A constant part of the mean flow passes during the whole beat. The other part of the mean flow rises and
// falls once per beat. These fractions are assumptions (docs/contrast.md).
constexpr double systemic_even = 0.6;        // the hump fills systole
constexpr double left_coronary_even = 0.25;  // the hump fills diastole
constexpr double right_coronary_even = 0.75; // the hump fills diastole

// The curve over `place`, 0 .. 1, is 0 at both ends and 15/8 in the middle; its mean is 1.
double hump(double place)
{
    const double rise = place * (1.0 - place);
    return 30.0 * rise * rise;
}

// Returns the present conductance of a vascular bed divided by its mean over a beat. The fraction `even` of
// the conductance is constant, and the remainder rises and falls once within `length_s`.
double openness(double even, bool is_in_hump, double place, double length_s, double beat_s)
{
    return even + (is_in_hump ? (1.0 - even) * hump(place) * beat_s / length_s : 0.0);
}

} // namespace

FlowDrive flow_drive(const BeatPhase &phase)
{
    FlowDrive drive;
    if (!phase.is_beating || !(phase.beat_s > 0.0)) {
        drive.pressure_mmHg = 0.0;
        return drive;
    }
    const double systole_s = std::clamp(phase.systole_s, 0.1 * phase.beat_s, 0.9 * phase.beat_s);
    const double diastole_s = phase.beat_s - systole_s;
    const double since_s = std::clamp(phase.since_opening_s, 0.0, phase.beat_s);
    const bool is_systole = since_s < systole_s;
    const double place = is_systole ? since_s / systole_s : (since_s - systole_s) / diastole_s;
    const double systemic = openness(systemic_even, is_systole, place, systole_s, phase.beat_s);
    drive.openness = {systemic, openness(left_coronary_even, !is_systole, place, diastole_s, phase.beat_s),
                      openness(right_coronary_even, !is_systole, place, diastole_s, phase.beat_s), systemic,
                      systemic};
    return drive;
}

BeatPhase core_beat(double beat_ms, double interval_ms, bool is_resting)
{
    constexpr double opens_share = 0.24;
    BeatPhase phase;
    phase.beat_s = std::max(interval_ms, 200.0) * 1e-3;
    const double systole_s = std::clamp(0.540 - 0.0021 * 60.0 / phase.beat_s, 0.1, 0.8 * phase.beat_s);
    const double opens_s = opens_share * systole_s, since_qrs_s = beat_ms * 1e-3;
    phase.systole_s = systole_s - opens_s;
    phase.since_opening_s = since_qrs_s - opens_s + (since_qrs_s < opens_s ? phase.beat_s : 0.0);
    phase.is_beating = !is_resting;
    return phase;
}

BeatPhase steady_beat(std::uint32_t tick, double beats_per_min)
{
    const double rate = std::clamp(beats_per_min, 20.0, 250.0);
    BeatPhase phase;
    phase.beat_s = 60.0 / rate;
    phase.systole_s = std::max(0.413 - 0.0017 * rate, 0.1);
    const double beats = tick * 1e-3 / phase.beat_s;
    phase.since_opening_s = (beats - std::floor(beats)) * phase.beat_s;
    return phase;
}

} // namespace crn
