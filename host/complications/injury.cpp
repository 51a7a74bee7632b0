#include "host/complications/injury.hpp"
#include "host/base/number_text.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace crn
{
namespace
{

constexpr double mean_mmHg = 88.0,
                 Pa_per_mmHg = 133.322;                 // of the arteries above the veins (docs/contrast.md)
constexpr double blood_kg_m3 = 1060.0, discharge = 0.6; // of a sharp-edged orifice
constexpr double most_narrowing = 0.99;

} // namespace

double balloon_hole_mm(const ComplicationLimits &limits, double ratio)
{
    return limits.balloon_hole_mm +
           limits.balloon_hole_mm_per_ratio * std::max(ratio - limits.perforation_balloon_ratio, 0.0);
}

// The flow through an orifice, C A sqrt(2 p / rho), rises with the root of the pressure; the network needs a
// conductance. It gives the orifice's flow at the arteries' mean pressure.
double hole_ml_s_per_mmHg(const ComplicationLimits &limits, double diameter_mm)
{
    const double area_m2 = 0.25 * std::numbers::pi * diameter_mm * diameter_mm * 1e-6;
    const double speed_m_s = std::sqrt(2.0 * mean_mmHg * Pa_per_mmHg / blood_kg_m3);
    return 0.01 * limits.hole_open_pct * discharge * area_m2 * speed_m_s * 1e6 / mean_mmHg;
}

double flap_narrowing(const ComplicationLimits &limits, InjuryCause cause, double value, double limit)
{
    const double slope_pct =
        cause == InjuryCause::tip ? limits.tip_narrowing_pct : limits.balloon_narrowing_pct;
    // Beyond this, a balloon makes a hole instead of a larger flap.
    const double most = cause == InjuryCause::tip ? value : limits.perforation_balloon_ratio;
    const double beyond = std::max(std::min(value, most) / limit - 1.0, 0.0);
    const double pct = limits.flap_narrowing_pct + slope_pct * beyond;
    return std::min(0.01 * pct, most_narrowing);
}

std::string injury_class(const Injury &injury, const ComplicationLimits &limits)
{
    if (injury.kind == InjuryKind::perforation) {
        if (injury.size_mm < limits.crater_below_mm) return "I";
        return injury.size_mm < limits.jet_mm ? "II" : "III";
    }
    // Type A leaves no trace, and is not simulated.
    if (injury.narrowing >= 0.9) return "F";
    if (injury.narrowing >= 0.7) return "E";
    if (injury.narrowing >= 0.5) return "D";
    return injury.narrowing >= 0.3 ? "C" : "B";
}

std::string injury_notice(const Injury &injury, const ComplicationLimits &limits)
{
    const bool is_hole = injury.kind == InjuryKind::perforation;
    const std::string by = injury.cause == InjuryCause::tip
                               ? "tip of " + injury.tool
                               : injury.tool + " at " + decimals_text(injury.value, 2) + " of the vessel";
    const std::string what = is_hole ? "PERFORATION, Ellis " : "DISSECTION, type ";
    const std::string remedy = is_hole ? "keep the wire across, inflate a balloon of the vessel's size there "
                                         "at low pressure, then look with medium"
                                       : "keep the wire in the true lumen, stop pushing, look with medium; a "
                                         "stent closes the flap";
    return what + injury_class(injury, limits) + " of " + injury.vessel + " by the " + by + " - " + remedy;
}

double pressure_left(const ComplicationLimits &limits, double around_heart_ml, double all_ml)
{
    const auto lost = [](double ml, double begins_ml, double full_ml) {
        return std::clamp((ml - begins_ml) / std::max(full_ml - begins_ml, 1e-9), 0.0, 1.0);
    };
    const double worst = std::max(lost(around_heart_ml, limits.tamponade_begins_ml, limits.tamponade_full_ml),
                                  lost(all_ml, limits.shock_begins_ml, limits.shock_full_ml));
    return 1.0 - worst * (1.0 - 0.01 * limits.pressure_left_pct);
}

bool LimitWatch::take(std::uint32_t tick, double value, double limit, double hold_ms)
{
    if (!(value > limit)) {
        is_above_ = false;
        return false;
    }
    if (!is_above_) since_ = tick;
    is_above_ = true;
    return tick - since_ >= hold_ms;
}

void LimitWatch::archive(StateArchive &state)
{
    state.flag(is_above_);
    state.integer(since_);
}

void archive_injury(StateArchive &state, Injury &injury)
{
    state.choice(injury.kind, InjuryKind::dissection);
    state.choice(injury.cause, InjuryCause::balloon);
    state.integer(injury.tick);
    state.text(injury.tool);
    state.text(injury.vessel);
    state.reals({injury.place_m.data(), 3}, -10.0, 10.0);
    state.reals({injury.outward.data(), 3}, -2.0, 2.0);
    for (double *value : {&injury.value, &injury.limit, &injury.force_N, &injury.size_mm})
        state.real(*value, 0.0, 1e9);
    state.real(injury.narrowing, 0.0, 1.0);
    for (std::size_t *index : {&injury.cell, &injury.cells, &injury.wound}) state.index(*index, 1u << 30);
    state.flag(injury.bleeds);
}

} // namespace crn
