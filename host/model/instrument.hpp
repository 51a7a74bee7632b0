// Reads instrument files (TOML, docs/instruments.md). The reader returns three things: the
// record `instrument` of the byte protocol, the instrument's unloaded shape, and its X-ray layers.
//
// An instrument file describes one instrument from its tip to its hub, in one or more presets. The path
// "file.toml" selects the preset `physical`, and "file.toml:vcsim3-fit" selects the preset `vcsim3-fit`. In
// an instrument file, the key of every value contains the unit, and every value is accompanied by its source.
// Error messages about an instrument file name file, line, preset, section and key.
#pragma once
#include "shared/wire/wire.h"
#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace crn
{

// Describes what X-rays meet in one stretch of the instrument: the material, and the fraction of the layer's
// cross-section that this material fills.
struct InstrumentLayer {
    double arc_begin_m = 0.0; // from the distal tip
    double arc_end_m = 0.0;
    std::string material;      // name as in docs/xray.md
    double fill = 1.0;         // share of the layer's cross-section, 0 .. 1
    double radius_share = 1.0; // of the outer radius, 0 .. 1
};

// Describes a stretch of the instrument that has a constant curvature in the unloaded shape. Component 1 of
// the curvature turns the tip towards the material axis d1, and component 2 turns it towards d2.
struct InstrumentArc {
    std::string name;
    double arc_begin_m = 0.0; // from the distal tip
    double arc_end_m = 0.0;
    double curvature1_per_m = 0.0, curvature2_per_m = 0.0;
};

// Describes one row of Table 5.1 of the VCSim3 thesis, with the powers of ten of its header applied. The
// thesis does not give the SI units of these numbers; docs/instruments.md explains how the numbers are
// interpreted, and why they are not physical values.
struct ThesisRow {
    std::string row;
    double young_modulus = 0.0;         // "Eb (1x10^7)", read as Pa
    double radius_m = 0.0;              // "Radius (1x10^3)", read as 1e-4 m per unit of the column
    double density = 0.0;               // "Density (1x10^5)"
    double kp = 0.0;                    // "Kp (1x10^3)"
    double bend_stiffness_N_m2() const; // E pi r^4 / 4
};

// Describes round holes in a catheter's wall, which are evenly spaced from the first to the last hole.
struct SideHoles {
    double arc_begin_m = 0.0, arc_end_m = 0.0; // of the first and the last, from the distal tip
    std::uint32_t count = 0;
    double diameter_m = 0.0;
};

// Describes the data on a balloon's label, without its table of pressures and diameters.
struct BalloonLabel {
    double nominal_kPa = 0.0, rated_burst_kPa = 0.0;
    double crossing_profile_m = 0.0;   // largest diameter when folded
    std::vector<double> marker_arcs_m; // middles of its marker bands, from the tip
};

enum class InstrumentKind { wire, catheter };

struct Instrument {
    std::string name; // followed by the preset unless that is `physical`
    std::string description, shape_name, preset;
    std::vector<std::string> presets; // presets of the file, `physical` first
    InstrumentKind kind = InstrumentKind::wire;
    double length_m = 0.0;
    crn_wire_instrument table{}; // validated by the device
    std::vector<InstrumentLayer> layers;
    std::vector<InstrumentArc> shape; // from the tip; straight beyond the last one
    std::vector<SideHoles> side_holes;
    std::optional<BalloonLabel> balloon; // its table is in `table`
    std::optional<ThesisRow> thesis;     // for a preset that was made from the table
};

// `path` may end in ":preset". Every preset of the file is read and checked, even if the caller requests
// another preset. Throws FileError.
Instrument read_instrument(const std::string &path);

// Splits "a.toml:b" into {"a.toml", "b"}; without a preset the second string is empty.
std::pair<std::string, std::string> split_preset(const std::string &path);

// Returns "'Bentson' (0.889 mm) does not pass the lumen of 'Terumo 4F' (0.8 mm, at 30 mm from its tip)", or
// an empty text if the inner instrument fits. The core decides by the same rule whether it refuses nested
// tools.
std::string nesting_refusal(const Instrument &inside, const Instrument &outer);

// Returns the number of nodes of the core's mesh (docs/rod.md), for one instrument or for several nested
// instruments. Nested instruments share one mesh. For several instruments, this mesh has the shortest
// elements that any of them has at its tip and at its shaft, the longest finely meshed part and the greatest
// length. The number of nodes is at most CRN_NODE_MAX of the core.
inline constexpr int line_nodes_max = 384;
int line_node_count(std::span<const crn_wire_instrument *const> tools);
int line_node_count(const crn_wire_instrument &tool);

// Returns points of the instrument's unloaded centreline, tip first, from the tip to `straight_m` behind the
// last arc. The list of points of the centreline contains a point every `step_m` and at every change of
// curvature. The straight part of the shape lies on the x axis; the origin is at its end nearer to the user's
// hand. The instrument enters along +x; d1 is +y, and d2 = t x d1 is -z, where t points along the instrument
// towards the user's hand.
struct ShapePoint {
    double arc_m = 0.0;
    Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d forward = Eigen::Vector3d::UnitX(); // unit, towards the tip
};
std::vector<ShapePoint> unloaded_shape(const Instrument &instrument, double step_m, double straight_m);

} // namespace crn
