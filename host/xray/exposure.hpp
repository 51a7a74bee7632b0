// Simulates the generator and automatic exposure control, which choose the tube voltage, current, pulse width
// and copper filter of a picture.
//
// The exposure control works as in angiography systems (AAPM Report 125; Rauch, Lin et al., Med Phys 39
// (2012) 2826). The exposure control estimates the patient's thickness as centimetres of water from the
// signal of the last pulse. A fixed curve gives the technique (voltage, current, pulse width) for the
// estimated thickness of the patient.
//
// On the fixed curve of the exposure control (an "anti-isowatt" curve), voltage, current and pulse width
// increase together. At the limit of the current, or at the power limit of the tube ("isowatt"), only the
// voltage increases further, to 125 kV.
//
// The exposure control takes the thickest copper filter with which the voltage stays low enough for iodine
// (80 kV in fluoroscopy, 75 kV otherwise). With the thinnest copper filter the voltage may exceed the limit
// for iodine. The exposure control returns to a thicker copper filter only if that filter needs a voltage at
// least 4 kV below the limit for iodine.
//
// Fluoroscopy never exceeds 88 mGy/min at the reference point (21 CFR 1020.32). If the kerma rate reaches its
// limit, pictures are underexposed, as in real systems.
//
// With each pulse the estimated thickness moves half-way to the thickness that the signal shows, but by at
// most 3 cm, so that a new view settles within about five pulses.
//
// Manufacturers do not publish the numbers of their exposure curves. The exposure curves below are
// assumptions within the limits of angiography tubes.
#pragma once
#include "host/xray/beam_table.hpp"
#include <cstdint>
#include <map>
#include <span>
#include <utility>

namespace crn
{

enum class ExposureMode : std::uint8_t { fluoro, cine, dsa };

struct XrayTechnique {
    double tube_voltage_kV = 75.0; // peak; 60 .. 125
    double tube_current_mA = 50.0; // during the pulse
    double pulse_ms = 6.0;
    double copper_mm = 0.3; // in addition to 2.5 mm Al: 0.1, 0.2, 0.3, 0.6 or 0.9
    double focal_spot_mm = 0.4;

    double charge_mAs() const { return tube_current_mA * pulse_ms * 1e-3; }
    bool operator==(const XrayTechnique &) const = default;
};

// The task of one pulse.
struct ExposureDemand {
    ExposureMode mode = ExposureMode::fluoro;
    double dose_nGy = 40.0; // behind patient and grid, mean over the measuring field; see wanted_quanta_mm2
    double frame_period_ms = 1000.0 / 15.0;
    double source_detector_m = 1.05;
    double source_isocentre_m = 0.75;

    bool operator==(const ExposureDemand &) const = default;
};

// The control's state between pulses.
struct ExposureState {
    double water_cm = 20.0; // estimated thickness of the patient, scatter included
    double copper_mm = 0.3;
};

struct ExposureChoice {
    XrayTechnique technique;
    bool is_limited = false; // the curve ends below the demanded dose
};

// The reference point lies 15 cm from the isocentre, towards the tube (IEC 60601-2-54).
inline constexpr double reference_point_m = 0.15;

// Gives the fraction of primary photons that the anti-scatter grid transmits; scatter.hpp has the fraction
// for scattered photons.
inline constexpr double grid_primary = 0.706;

// Holds the curves of automatic exposure, and the tables of the X-ray beams used so far.
class Exposure
{
  public:
    // Chooses the technique for the next pulse, and stores the chosen copper filter in `state`.
    ExposureChoice choose(const ExposureDemand &demand, ExposureState &state);

    // Updates the estimated thickness of the patient from the last pulse's signal behind patient and grid,
    // divided by the open beam's signal.
    void follow(const XrayTechnique &technique, double signal_share, ExposureState &state);
    // For a single picture without earlier pulses, sets the patient's estimated thickness at once to the
    // value that the signal shows.
    void jump(const XrayTechnique &technique, double signal_share, ExposureState &state);

    // Returns how many quanta per mm2 of this beam give the same signal as a dose of `dose_nGy` in the
    // calibration beam. The calibration beam of the detector and the exposure control has 75 kV and 0.2 mm
    // copper, and passes 20 cm of tissue.
    double wanted_quanta_mm2(double dose_nGy, const BeamTable &beam);

    // The voltage is rounded to whole kilovolts, as real generators do.
    const BeamTable &table(double tube_voltage_kV, double copper_mm);

  private:
    struct Candidate {
        XrayTechnique technique;
        bool is_enough = false;
    };
    Candidate on_curve(const ExposureDemand &demand, double water_cm, double copper_mm, int kV);
    Candidate lowest_voltage(const ExposureDemand &demand, double water_cm, double copper_mm);
    double estimate_water_cm(const XrayTechnique &technique, double signal_share);

    std::map<std::pair<int, int>, BeamTable> tables_; // by kV and 0.01 mm copper
};

// Returns the thicknesses of the copper filters for an exposure mode, thickest first.
std::span<const double> copper_filters_mm(ExposureMode mode);

// Returns the current and the pulse width of the exposure curve at a voltage, before they are lowered to give
// the demanded dose.
XrayTechnique curve_point(ExposureMode mode, double tube_voltage_kV);

// Returns the quanta per mm2 that a technique brings to the detector behind the grid without a patient.
double open_quanta_mm2(const BeamTable &table, const XrayTechnique &technique, double source_detector_m);

// Limits a technique (voltage, current, pulse width, filter) to the ranges of tube and generator.
XrayTechnique held_technique(const XrayTechnique &technique);

// Returns the air kerma at the reference point, in uGy per pulse.
double reference_kerma_uGy(const BeamTable &table, const XrayTechnique &technique, double source_isocentre_m);

} // namespace crn
