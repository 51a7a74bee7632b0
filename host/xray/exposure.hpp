// Generator and automatic exposure control: which tube voltage, current, pulse and copper filter a picture is
// taken with.
//
// Control works as angiography systems do (AAPM Report 125; Rauch, Lin et al., Med. Phys. 39 (2012) 2826):
// from the last pulse's signal it estimates the patient as centimetres of water, and looks the technique up
// on a fixed curve.
// - Curve ("anti-isowatt"): voltage, current and pulse width rise together; at the current's limit or the
// tube's power limit
//   ("isowatt") only the voltage rises further, to 125 kV.
// - Filter: the thickest copper with which the voltage stays low enough for iodine (80 kV in fluoroscopy, 75
// else);
//   the thinnest one has the rest of the curve. A thicker one comes back only when 4 kV less are enough with
//   it.
// - Fluoroscopy never exceeds 88 mGy/min at the reference point (the limit of 21 CFR 1020.32); past a limit
// pictures are
//   underexposed, as real ones are.
// - Half of the difference in thickness, at most 3 cm, is followed per pulse: a new view settles within about
// five pulses. Which curve a maker uses is not published with numbers; those below are an assumption within
// the limits of such tubes.
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
    double copper_mm = 0.3; // besides 2.5 mm Al: 0.1, 0.2, 0.3, 0.6 or 0.9
    double focal_spot_mm = 0.4;

    double charge_mAs() const { return tube_current_mA * pulse_ms * 1e-3; }
    bool operator==(const XrayTechnique &) const = default;
};

// What one pulse has to do.
struct ExposureDemand {
    ExposureMode mode = ExposureMode::fluoro;
    double dose_nGy = 40.0; // behind patient and grid, mean over the measuring field; see wanted_quanta_mm2
    double frame_period_ms = 1000.0 / 15.0;
    double source_detector_m = 1.05;
    double source_isocentre_m = 0.75;

    bool operator==(const ExposureDemand &) const = default;
};

// Where the control stands between pulses.
struct ExposureState {
    double water_cm = 20.0; // estimate of the patient, scatter included
    double copper_mm = 0.3;
};

struct ExposureChoice {
    XrayTechnique technique;
    bool is_limited = false; // the curve ends below the dose asked for
};

// From the isocentre toward the tube (IEC 60601-2-54).
inline constexpr double reference_point_m = 0.15;

// Primary photons that an anti-scatter grid lets through (scatter.hpp has the scattered ones).
inline constexpr double grid_primary = 0.706;

// The grid, the curves and the tables of the beams used so far.
class Exposure
{
  public:
    // Technique for the next pulse; the copper chosen becomes the state's.
    ExposureChoice choose(const ExposureDemand &demand, ExposureState &state);

    // Takes the last pulse's signal behind patient and grid, as share of the open beam's, into the estimate.
    void follow(const XrayTechnique &technique, double signal_share, ExposureState &state);
    // The same without delay, for a single picture.
    void jump(const XrayTechnique &technique, double signal_share, ExposureState &state);

    // Quanta per mm2 of this beam that give the signal which `dose_nGy` gives in the beam that detector and
    // control are calibrated with: 75 kV, 0.2 mm copper, behind 20 cm of tissue.
    double wanted_quanta_mm2(double dose_nGy, const BeamTable &beam);

    // Voltage is taken to whole kilovolts, as generators do.
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

// Copper filters of a mode, thickest first.
std::span<const double> copper_filters_mm(ExposureMode mode);

// Current and pulse width at a voltage of the curve, before they are lowered to what is needed.
XrayTechnique curve_point(ExposureMode mode, double tube_voltage_kV);

// Quanta per mm2 of detector that a technique brings without patient, behind the grid.
double open_quanta_mm2(const BeamTable &table, const XrayTechnique &technique, double source_detector_m);

// Within what tube and generator can do.
XrayTechnique held_technique(const XrayTechnique &technique);

// Air kerma at the reference point, uGy per pulse.
double reference_kerma_uGy(const BeamTable &table, const XrayTechnique &technique, double source_isocentre_m);

} // namespace crn
