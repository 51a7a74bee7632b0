// Measures the X-ray beam of the simulated tube.
#include "host/xray/exposure.hpp"
#include "host/xray/spectrum.hpp"
#include "tools/lab/literature/experiments.hpp"

#include <cmath>

namespace crn::literature
{

namespace
{

double kerma_behind(const Spectrum &beam, double aluminium_mm)
{
    Spectrum filtered = beam;
    for (int k = 0; k < energy_count; k++)
        filtered[std::size_t(k)] *= std::exp(-aluminium_per_cm[k] * aluminium_mm / 10);
    return air_kerma_uGy(filtered);
}

// Adds aluminium until the chamber shows half of the kerma.
double half_value_layer_mm(double kV, double copper_mm)
{
    const Spectrum beam = tube_spectrum(kV, copper_mm);
    const double half = kerma_behind(beam, 0) / 2;
    double low = 0, high = 30;
    while (high - low > 1e-4) {
        const double middle = (low + high) / 2;
        (kerma_behind(beam, middle) > half ? low : high) = middle;
    }
    return low;
}

Figures radiation_qualities()
{
    Figures figures;
    for (auto [name, kV] : {std::pair{"rqr_2", 40},
                            {"rqr_3", 50},
                            {"rqr_4", 60},
                            {"rqr_5", 70},
                            {"rqr_6", 80},
                            {"rqr_7", 90},
                            {"rqr_8", 100},
                            {"rqr_9", 120}})
        figures.values[name] = half_value_layer_mm(kV, 0);
    figures.values["rqt_8"] = half_value_layer_mm(100, 0.2);
    figures.values["rqt_9"] = half_value_layer_mm(120, 0.25);
    validate::Plot plot{
        "Half-value layer of the beam behind 2.5 mm Al", "tube voltage (kV)", "half-value layer (mm Al)", {}};
    validate::Series ours{"ours", {}, {}};
    for (int kV = 40; kV <= 125; kV += 5) {
        ours.x.push_back(kV);
        ours.y.push_back(half_value_layer_mm(kV, 0));
    }
    plot.series = {ours,
                   {"IEC 61267, RQR",
                    {40, 50, 60, 70, 80, 90, 100, 120},
                    {1.4, 1.8, 2.2, 2.6, 3.0, 3.5, 4.0, 5.0},
                    true}};
    figures.curves.push_back(plot);
    return figures;
}

// The skin of a patient on the table: fluoroscopy with 15 pulses per second through water, with the dose at
// the detector of docs/room.md. The skin lies half of the thickness before the isocentre.
double skin_mGy_min(double water_cm)
{
    constexpr double backscatter = 1.35; // of 80 kV behind copper, fields of 20 cm
    Exposure exposure;
    ExposureState state;
    state.water_cm = water_cm;
    const ExposureDemand demand;
    ExposureChoice choice = exposure.choose(demand, state);
    const BeamTable &beam = exposure.table(choice.technique.tube_voltage_kV, choice.technique.copper_mm);
    const double reference_uGy = reference_kerma_uGy(beam, choice.technique, demand.source_isocentre_m);
    const double reference_m = demand.source_isocentre_m - reference_point_m,
                 skin_m = demand.source_isocentre_m - water_cm / 200;
    const double per_min = 60e3 / demand.frame_period_ms;
    return reference_uGy * 1e-3 * per_min * std::pow(reference_m / skin_m, 2) * backscatter;
}

Figures fluoroscopy_dose()
{
    Figures figures;
    validate::Series series{"ours", {}, {}};
    for (double cm = 14; cm <= 30; cm += 1) {
        series.x.push_back(cm);
        series.y.push_back(skin_mGy_min(cm));
    }
    for (int cm : {20, 22, 25}) figures.values["water_" + std::to_string(cm) + "_cm"] = skin_mGy_min(cm);
    figures.curves.push_back(
        {"Fluoroscopy, 15 pulses per second", "water (cm)", "skin dose rate (mGy/min)", {series}});
    return figures;
}

} // namespace

std::vector<Experiment> beam_experiments()
{
    return {{"half_value_layers", radiation_qualities}, {"fluoroscopy_dose", fluoroscopy_dose}};
}

} // namespace crn::literature
