// The generator and automatic exposure control choose the tube voltage, current, pulse and copper filter of a
// picture.
//
// Control works as angiography systems do (AAPM Report 125; Rauch, Lin et al., Med. Phys. 39 (2012) 2826).
// From the last pulse's signal it estimates the patient's thickness as centimetres of water, and takes the
// technique from a fixed curve.
// - Curve ("anti-isowatt"): voltage, current and pulse width rise together. At the current's limit or the
//   tube's power limit ("isowatt") only the voltage rises further, to 125 kV.
// - Filter: the control takes the thickest copper at which the voltage stays low enough for iodine (80 kV in
//   fluoroscopy, 75 kV otherwise). The thinnest filter has the rest of the curve. A thicker filter comes back
//   only when it needs 4 kV less than that limit.
// - Limit: fluoroscopy never exceeds 88 mGy/min at the reference point (21 CFR 1020.32). At the limit
//   pictures are underexposed, as in real systems.
// - Speed: the estimate follows half of the difference in thickness per pulse, at most 3 cm, so that a new
//   view settles within about five pulses.
// Manufacturers do not publish their curves with numbers; those below are an assumption within the limits of
// such tubes.
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

// Distance of the reference point from the isocentre toward the tube (IEC 60601-2-54).
inline constexpr double reference_point_m = 0.15;

// Share of primary photons that an anti-scatter grid transmits (scatter.hpp has the share of scattered ones).
inline constexpr double grid_primary = 0.706;

// The grid, the curves and the tables of the beams used so far.
class Exposure
{
  public:
    // Chooses the technique for the next pulse; the chosen copper is stored in the state.
    ExposureChoice choose(const ExposureDemand &demand, ExposureState &state);

    // Updates the estimate from the last pulse's signal behind patient and grid, given as a share of the open
    // beam's.
    void follow(const XrayTechnique &technique, double signal_share, ExposureState &state);
    // Does the same without delay, for a single picture.
    void jump(const XrayTechnique &technique, double signal_share, ExposureState &state);

    // Returns the quanta per mm2 of this beam that give as much signal as `dose_nGy` gives in the calibration
    // beam of detector and control: 75 kV, 0.2 mm copper, behind 20 cm of tissue.
    double wanted_quanta_mm2(double dose_nGy, const BeamTable &beam);

    // The voltage is rounded to whole kilovolts, as in generators.
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

// Returns the copper filters of a mode, thickest first.
std::span<const double> copper_filters_mm(ExposureMode mode);

// Returns current and pulse width at a voltage of the curve, before they are lowered to the demanded dose.
XrayTechnique curve_point(ExposureMode mode, double tube_voltage_kV);

// Returns the quanta per mm2 of detector that a technique brings without a patient, behind the grid.
double open_quanta_mm2(const BeamTable &table, const XrayTechnique &technique, double source_detector_m);

// Limits a technique to the ranges of tube and generator.
XrayTechnique held_technique(const XrayTechnique &technique);

// Returns the air kerma at the reference point, uGy per pulse.
double reference_kerma_uGy(const BeamTable &table, const XrayTechnique &technique, double source_isocentre_m);

} // namespace crn
