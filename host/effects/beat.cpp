#include "host/effects/beat.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

// A constant part of the mean flow passes during the whole beat. The other part of the mean flow rises and
// falls once per beat. The left fraction is fitted to Doppler wires in patients, and the right one is assumed
// (docs/contrast.md).
constexpr double left_coronary_even = 0.65;  // the hump fills diastole
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

// The flow into the aorta over `share`, 0 .. 1, of the ejection, divided by its mean: it rises fast and falls
// slowly.
double ejection(double share)
{
    const double left = 1.0 - share;
    return 20.0 * share * left * left * left; // beta function B(2,4) = 1/20
}

// Returns exp(-x) for 0 <= x <= 4, within 2e-4 of itself. Without libm, every machine gives the same bits.
double decay(double x)
{
    const double y = x / 16.0;
    double power = 1.0 - y * (1.0 - y / 2.0 * (1.0 - y / 3.0 * (1.0 - y / 4.0)));
    for (int i = 0; i < 4; ++i) power *= power;
    return power;
}

// Returns what is left, at the fraction `share` of the ejection, of the pressure that the ejection has added
// since its beginning, divided by the mean pressure. Simpson's rule with 8 panels.
double added_by_ejection(double share, double systole_s, double beat_s)
{
    constexpr int panels = 8;
    const double step = share / (2 * panels);
    double sum = 0.0;
    for (int i = 0; i <= 2 * panels; ++i) {
        const double weight = i == 0 || i == 2 * panels ? 1.0 : i % 2 == 1 ? 4.0 : 2.0;
        sum += weight * ejection(i * step) * decay((share - i * step) * systole_s / windkessel_s);
    }
    return beat_s / windkessel_s * sum * step / 3.0;
}

} // namespace

// The pressure p of a windkessel that a flow q fills follows dp/dt = (q - p) / time constant, where both are
// divided by their means. A regular beat begins with the pressure with which it ends.
WindkesselPressure windkessel_pressure(double since_opening_s, double systole_s, double beat_s)
{
    const double whole = added_by_ejection(1.0, systole_s, beat_s);
    const double at_closing = whole / (1.0 - decay(beat_s / windkessel_s));
    WindkesselPressure now;
    if (since_opening_s >= systole_s) {
        now.pressure = at_closing * decay((since_opening_s - systole_s) / windkessel_s);
        now.per_s = -now.pressure / windkessel_s;
        return now;
    }
    const double at_opening = at_closing * decay((beat_s - systole_s) / windkessel_s);
    const double share = since_opening_s / systole_s;
    now.pressure =
        at_opening * decay(since_opening_s / windkessel_s) + added_by_ejection(share, systole_s, beat_s);
    now.per_s = (beat_s / systole_s * ejection(share) - now.pressure) / windkessel_s;
    return now;
}

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
    // The arteries behind an outlet take blood in while the pressure rises, and give it off while it falls.
    const WindkesselPressure aortic = windkessel_pressure(since_s, systole_s, phase.beat_s);
    drive.aortic_pressure = aortic.pressure;
    drive.is_valve_open = is_systole;
    const double systemic = std::max(aortic.pressure + windkessel_beyond_s * aortic.per_s, 0.0);
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
