// Holds one run of frames that the X-ray room acquired, from which cine loops, masks and files are made. The
// room adds the frames one by one, and host/dicom writes the run to files. It is plain data.
#pragma once
#include "host/xray/paths/carm.hpp"
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

enum class RunKind { fluoro, cine, dsa };

// States how raw pixel values relate to the X-ray intensity at the detector: LIN, LOG and DISP of PS3.3
// C.8.7.1.1.2.
enum class PixelRelation {
    linear,      // proportional to it
    logarithmic, // proportional to its logarithm
    display,     // changed for viewing, no fixed relation
};

// Describes the part of the picture that the collimator leaves open, in pixels from the left and top edge.
// The open part is a rectangle or a circle.
struct RunCollimator {
    bool is_circular = false;
    int left = 0, right = 0, top = 0, bottom = 0; // open columns [left, right), rows [top, bottom)
    double centre_x_px = 0.0, centre_y_px = 0.0;  // of the circle; the middle of pixel 0 is 0.5
    double radius_px = 0.0;
};

struct RunFrame {
    std::uint32_t tick = 0;         // of the session, ms: when the pulse began
    CArm carm;                      // angles, table (isocentre_m), SID, SOD and field at that moment
    double tube_voltage_kV = 0.0;   // peak
    double tube_current_mA = 0.0;   // mean over the pulse
    double pulse_ms = 0.0;          // width of the pulse
    double air_kerma_uGy = 0.0;     // at the reference point, 15 cm from the isocentre toward the tube
    double kap_Gy_cm2 = 0.0;        // kerma times area, the same at every distance
    double raw_open = 0.0;          // raw value of the open beam, by calibration; 0: not known, or no scatter
    std::vector<std::uint16_t> raw; // size*size, row 0 on top
};

// Lists the beam's filters, in the order in which the beam passes through them. The filters have the material
// names of PS3.3 C.8.7.10, Filter Material: "copper", "aluminum".
struct RunFilter {
    std::string material;
    double thickness_mm = 0.0;
};

struct RunContrast {
    std::string agent;         // "iohexol"
    double iodine_mg_ml = 0.0; // of the injected fluid
    double volume_ml = 0.0;    // injected during the run
    double flow_ml_s = 0.0;
    std::uint32_t tick_begin = 0; // of the session
    double duration_s = 0.0;
};

// The mask of a DSA run is the mean of the frames that this list names. The mean frame (mask) is shifted and
// subtracted from every other frame.
struct RunMask {
    std::vector<int> frames; // counted from 0 within the run; at least one
    double shift_x_px = 0.0; // shift of the mask to the right ...
    double shift_y_px = 0.0; // ... and down, before it is subtracted
};

struct XrayRun {
    RunKind kind = RunKind::fluoro;
    int number = 1;            // within the session, from 1
    int size = 0;              // pixels along each edge, the same in every frame
    double pulses_per_s = 0.0; // nominal; frames may be further apart, and their ticks give the true times
    PixelRelation relation = PixelRelation::linear;
    // Converts every raw value of a logarithmic run to a value proportional to the intensity (see
    // make_logarithmic()); other runs have no such table.
    std::vector<std::uint16_t> to_linear;
    int bits = 16;              // stored per pixel: 8, 10, 12 or 16
    double window_centre = 0.0; // raw values: the window in which a viewer first shows the run
    double window_width = 0.0;
    RunCollimator collimator;
    std::vector<RunFilter> filters;
    double focal_spot_mm = 0.0;  // nominal; 0: not known
    std::optional<RunMask> mask; // DSA
    std::optional<RunContrast> contrast;
    std::vector<RunFrame> frames; // in order of time
};

// Replaces each raw value of a linear run with 16 bits by 65535/16 log2(1 + value), and converts the run's
// display window in the same way. One step of the logarithmic values is a change of the intensity by 0.017 %.
// The difference of two logarithmic frames is the DSA picture, also in viewers that cannot compute
// logarithms.
void make_logarithmic(XrayRun &run);
// Returns the table of the logarithmic conversion, which has 65,536 entries; XrayRun::to_linear has the
// inverse table.
const std::vector<std::uint16_t> &logarithm_table();

} // namespace crn
