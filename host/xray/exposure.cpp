// Implements automatic exposure: its fixed curves, and the control that uses these curves.
#include "host/xray/exposure.hpp"
#include "host/xray/float_math.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

constexpr int voltage_min_kV = 60, voltage_max_kV = 125;
constexpr double kerma_rate_max_uGy_ms = 88e3 / 60e3; // fluoroscopy
constexpr double water_min_cm = 0.5, water_max_cm = 60.0;
constexpr double follow_share = 0.5, follow_max_cm = 3.0;
constexpr int filter_hysteresis_kV = 4;

constexpr double fluoro_filters[] = {0.9, 0.6, 0.3, 0.2, 0.1};
constexpr double cine_filters[] = {0.6, 0.3, 0.2, 0.1};
constexpr double dsa_filters[] = {0.3, 0.2, 0.1};

// From the lowest voltage to `knee_kV`, current and pulse width increase linearly with the voltage.
struct Curve {
    double knee_kV;
    double current_low_mA, current_high_mA, pulse_low_ms, pulse_high_ms;
    double power_max_kW, focal_spot_mm;
    int iodine_kV; // with all filters but the thinnest
};
constexpr Curve fluoro_curve = {80.0, 10.0, 100.0, 3.0, 10.0, 20.0, 0.4, 80};
constexpr Curve cine_curve = {80.0, 300.0, 800.0, 3.0, 10.0, 80.0, 0.8, 75};
constexpr Curve dsa_curve = {80.0, 300.0, 800.0, 10.0, 80.0, 80.0, 0.8, 75};

const Curve &curve_of(ExposureMode mode)
{
    return mode == ExposureMode::fluoro ? fluoro_curve : mode == ExposureMode::cine ? cine_curve : dsa_curve;
}

double square(double value)
{
    return value * value;
}

// Returns the detector's signal behind water, divided by the signal of the open beam.
double signal_behind(const BeamTable &table, double water_cm)
{
    const auto &tissue = table.log2_per_q10mm[static_cast<int>(Material::soft_tissue)];
    double sum = 0.0;
    for (int k = 0; k < beam_energy_count; ++k)
        sum += static_cast<double>(table.share[k]) *
               exp2_double(-static_cast<double>(tissue[k]) * 10240.0 * water_cm);
    return sum;
}

} // namespace

std::span<const double> copper_filters_mm(ExposureMode mode)
{
    if (mode == ExposureMode::fluoro) return fluoro_filters;
    if (mode == ExposureMode::cine) return cine_filters;
    return dsa_filters;
}

XrayTechnique curve_point(ExposureMode mode, double tube_voltage_kV)
{
    const Curve &curve = curve_of(mode);
    const double rise =
        std::clamp((tube_voltage_kV - voltage_min_kV) / (curve.knee_kV - voltage_min_kV), 0.0, 1.0);
    XrayTechnique point;
    point.tube_voltage_kV = tube_voltage_kV;
    point.tube_current_mA =
        std::min(curve.current_low_mA + rise * (curve.current_high_mA - curve.current_low_mA),
                 curve.power_max_kW * 1e3 / tube_voltage_kV);
    point.pulse_ms = curve.pulse_low_ms + rise * (curve.pulse_high_ms - curve.pulse_low_ms);
    point.focal_spot_mm = curve.focal_spot_mm;
    return point;
}

XrayTechnique held_technique(const XrayTechnique &technique)
{
    XrayTechnique held = technique;
    held.tube_voltage_kV =
        std::clamp(std::floor(technique.tube_voltage_kV + 0.5), static_cast<double>(voltage_min_kV),
                   static_cast<double>(voltage_max_kV));
    held.tube_current_mA = std::clamp(technique.tube_current_mA, 1.0, 800.0);
    held.pulse_ms = std::clamp(technique.pulse_ms, 0.1, 100.0);
    held.copper_mm = std::clamp(technique.copper_mm, 0.1, 0.9);
    held.focal_spot_mm = std::clamp(technique.focal_spot_mm, 0.1, 2.0);
    return held;
}

double open_quanta_mm2(const BeamTable &table, const XrayTechnique &technique, double source_detector_m)
{
    return table.quanta_mm2_mAs * technique.charge_mAs() * grid_primary / square(source_detector_m);
}

double reference_kerma_uGy(const BeamTable &table, const XrayTechnique &technique, double source_isocentre_m)
{
    return table.air_kerma_uGy_mAs * technique.charge_mAs() / square(source_isocentre_m - reference_point_m);
}

double Exposure::wanted_quanta_mm2(double dose_nGy, const BeamTable &beam)
{
    const BeamTable &reference = table(75.0, 0.2);
    return dose_nGy / reference.patient_nGy_quantum_mm2 * reference.quantum_keV / beam.quantum_keV;
}

const BeamTable &Exposure::table(double tube_voltage_kV, double copper_mm)
{
    const int kV = static_cast<int>(std::floor(tube_voltage_kV + 0.5));
    const int copper_10um = static_cast<int>(std::floor(copper_mm * 100.0 + 0.5));
    const auto [place, is_new] = tables_.try_emplace({kV, copper_10um});
    if (is_new) place->second = make_beam_table(kV, copper_10um * 0.01);
    return place->second;
}

// Returns the voltage, current and pulse width on the exposure curve at a given voltage. If the curve gives
// more than the demanded dose at this voltage, current and pulse width are lowered until the dose is the
// demanded one.
Exposure::Candidate Exposure::on_curve(const ExposureDemand &demand, double water_cm, double copper_mm,
                                       int kV)
{
    const Curve &curve = curve_of(demand.mode);
    const BeamTable &beam = table(kV, copper_mm);
    Candidate candidate{curve_point(demand.mode, kV), false};
    XrayTechnique &technique = candidate.technique;
    technique.copper_mm = copper_mm;
    const double brought =
        open_quanta_mm2(beam, technique, demand.source_detector_m) * signal_behind(beam, water_cm);
    double share = wanted_quanta_mm2(demand.dose_nGy, beam) / brought;
    candidate.is_enough = share <= 1.0;
    if (demand.mode == ExposureMode::fluoro) {
        const double kerma_uGy = reference_kerma_uGy(beam, technique, demand.source_isocentre_m);
        const double allowed = kerma_rate_max_uGy_ms * demand.frame_period_ms / kerma_uGy;
        if (allowed < std::min(share, 1.0)) {
            candidate.is_enough = false;
            share = allowed;
        }
    }
    if (share >= 1.0) return candidate;
    const double current_mA = technique.tube_current_mA;
    technique.tube_current_mA = std::max(current_mA * std::sqrt(share), curve.current_low_mA);
    technique.pulse_ms =
        std::max(technique.pulse_ms * share * current_mA / technique.tube_current_mA, curve.pulse_low_ms);
    return candidate;
}

// Finds the voltage by bisection, because a higher voltage always brings more dose to the detector.
Exposure::Candidate Exposure::lowest_voltage(const ExposureDemand &demand, double water_cm, double copper_mm)
{
    int low = voltage_min_kV, high = voltage_max_kV;
    while (low < high) {
        const int middle = (low + high) / 2;
        if (on_curve(demand, water_cm, copper_mm, middle).is_enough)
            high = middle;
        else
            low = middle + 1;
    }
    return on_curve(demand, water_cm, copper_mm, low);
}

ExposureChoice Exposure::choose(const ExposureDemand &demand, ExposureState &state)
{
    const std::span<const double> filters = copper_filters_mm(demand.mode);
    const int iodine_kV = curve_of(demand.mode).iodine_kV;
    Candidate candidate;
    for (double copper_mm : filters) {
        candidate = lowest_voltage(demand, state.water_cm, copper_mm);
        const bool is_last = copper_mm == filters.back();
        const bool is_thicker = copper_mm > state.copper_mm;
        const int allowed_kV = is_thicker ? iodine_kV - filter_hysteresis_kV : iodine_kV;
        if (is_last || (candidate.is_enough && candidate.technique.tube_voltage_kV <= allowed_kV)) break;
    }
    state.copper_mm = candidate.technique.copper_mm;
    return {candidate.technique, !candidate.is_enough};
}

double Exposure::estimate_water_cm(const XrayTechnique &technique, double signal_share)
{
    const BeamTable &beam = table(technique.tube_voltage_kV, technique.copper_mm);
    double low = water_min_cm, high = water_max_cm;
    for (int step = 0; step < 24; ++step) {
        const double middle = 0.5 * (low + high);
        (signal_behind(beam, middle) > signal_share ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

void Exposure::follow(const XrayTechnique &technique, double signal_share, ExposureState &state)
{
    const double change = estimate_water_cm(technique, signal_share) - state.water_cm;
    state.water_cm += std::clamp(follow_share * change, -follow_max_cm, follow_max_cm);
}

void Exposure::jump(const XrayTechnique &technique, double signal_share, ExposureState &state)
{
    state.water_cm = estimate_water_cm(technique, signal_share);
}

} // namespace crn
