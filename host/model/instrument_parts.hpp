// Reads the parts of an instrument file: sections of uniform construction, arcs of the unloaded shape, and
// the lengths of elements. The functions also compute from these parts how the instrument's values change
// along its length.
#pragma once
#include "host/base/toml_reader.hpp"
#include "host/model/instrument.hpp"

namespace crn::instrument_file
{

// Describes a part of the instrument between two arc lengths from the tip. Stiffness changes geometrically
// from the section's distal to its proximal end; all other values of the section change linearly.
struct Section {
    std::string name;
    TomlTable table; // for error messages
    double from_mm = 0.0, to_mm = 0.0;
    int steps = 1;
    TomlRange bend_N_m2{}, twist_N_m2{}, mass_kg_per_m{}, radius_outer_mm{}, radius_inner_mm{}, kinetic{},
        statical{};
    std::vector<InstrumentLayer> layers{};
};

struct Preset {
    std::string description;
    std::vector<Section> sections;
    double lumen_friction = 0.0;
    std::optional<ThesisRow> thesis;
};

inline constexpr NumberRange stiffness_bounds = {
    1e-7, 3e-2}; // N m^2, the core's limits (firmware/core/core.h, crn_knot)
inline constexpr NumberRange radius_bounds = {0.1, 2.0}; // mm
inline constexpr double length_max_mm = 1600.0;

// Reads [[section]] of a preset; values missing in a section come from [all].
std::vector<Section> read_sections(const TomlTable &preset, InstrumentKind kind);

// Reads [[shape]] from the tip.
std::vector<InstrumentArc> read_shape(const TomlTable &root);

// Reads [[side_holes]]; returns an empty list if the key is missing.
std::vector<SideHoles> read_side_holes(const TomlTable &root, InstrumentKind kind);

// Reads the table [balloon] of an instrument file. Stores the rows of pressures and diameters in the
// argument `wire`, and returns the data on the balloon's label. Returns no label if the key [balloon] is
// missing.
std::optional<BalloonLabel> read_balloon(const TomlTable &root, InstrumentKind kind,
                                         crn_wire_instrument &wire);

// Reads the table [material] of an instrument file. Stores the law of a round core of this material in the
// argument `wire`; without the key, the tool stays elastic.
void read_material(const TomlTable &root, InstrumentKind kind, crn_wire_instrument &wire);

// Refuses a material whose round core would be thicker than the wire. `wire` has its knots already.
void check_material(const TomlTable &root, const crn_wire_instrument &wire);

// Makes an instrument elastic.
void forget_material(crn_wire_instrument &wire);

// Adds the marker bands of the balloon to the instrument's X-ray layers.
void add_markers(Instrument &instrument);

void read_elements(const TomlTable &root, crn_wire_instrument &wire);

// Adds a knot, which holds the instrument's values at an arc length, to the instrument's table wherever a
// section or an arc changes.
void add_profile(const TomlTable &preset, const std::vector<Section> &sections, Instrument &instrument);

} // namespace crn::instrument_file
