// Reads [[section]], [all], [[shape]] and [elements] of an instrument file. The limits of the values are
// those of the core (firmware/core/core.h).
#include "host/base/format.hpp"
#include "host/model/instrument_parts.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace crn::instrument_file
{

namespace
{

constexpr NumberRange modulus_GPa_bounds = {1e-3, 250.0};
constexpr NumberRange twist_ratio_bounds = {0.05, 5.0};
constexpr NumberRange mass_bounds = {5e-4, 0.1};
constexpr NumberRange share_bounds = {0.0, 1.0};
constexpr double rad_per_deg = std::numbers::pi / 180.0;
constexpr double turn_max_deg = 720.0;
constexpr double curvature_max_per_m = 1000.0;

const std::vector<std::string> property_keys = {
    "bend_stiffness_N_m2", "flexural_modulus_GPa", "twist_stiffness_N_m2", "twist_to_bend",   "mass_kg_per_m",
    "radius_outer_mm",     "radius_inner_mm",      "friction_kinetic",     "friction_static", "xray"};

std::vector<std::string> with(const std::vector<std::string> &more)
{
    std::vector<std::string> keys = property_keys;
    keys.insert(keys.end(), more.begin(), more.end());
    return keys;
}

// Reads the values of a section. If the section does not give a value, the function takes it from the table
// [all].
class Values
{
  public:
    Values(const TomlTable &own, const std::optional<TomlTable> &all) : own_(own)
    {
        if (all) all_ = all->in_place_of(own);
    }

    const TomlTable &own() const { return own_; }

    TomlValue operator[](const std::string &key) const { return table_of(key)[key]; }

    TomlRange read(const std::string &key, NumberRange bounds) const
    {
        if (!(*this)[key]) missing(in_quotes(key));
        return table_of(key).sourced_range(key, bounds);
    }

    // Returns which of two mutually exclusive keys is given; the section's own takes precedence over that of
    // [all].
    std::string which(const std::string &a, const std::string &b) const
    {
        for (const TomlTable *table : {&own_, all_ ? &*all_ : nullptr}) {
            if (!table) continue;
            if (table->has(a) && table->has(b))
                (*table)[b].fail("gives both " + in_quotes(a) + " and " + in_quotes(b));
            if (table->has(a)) return a;
            if (table->has(b)) return b;
        }
        missing(in_quotes(a) + " or " + in_quotes(b));
    }

    [[noreturn]] void missing(const std::string &what) const
    {
        own_.fail(what + " is missing, here and in [all]");
    }

  private:
    const TomlTable &table_of(const std::string &key) const { return own_.has(key) || !all_ ? own_ : *all_; }

    const TomlTable &own_;
    std::optional<TomlTable> all_;
};

// Returns pi/4 (R^4 - r^4), the second moment of area in m^4 of a tube with the outer radius R and the inner
// radius r or, with r = 0, of a round wire; the radii are in mm.
double area_moment_m4(double outer_mm, double inner_mm)
{
    return std::numbers::pi / 4.0 * (std::pow(outer_mm, 4) - std::pow(inner_mm, 4)) * 1e-12;
}

TomlRange read_bend(const Values &values, const Section &section)
{
    const std::string key = values.which("bend_stiffness_N_m2", "flexural_modulus_GPa");
    if (key == "bend_stiffness_N_m2") return values.read(key, stiffness_bounds);
    const TomlRange modulus = values.read(key, modulus_GPa_bounds);
    const TomlRange &outer = section.radius_outer_mm, &inner = section.radius_inner_mm;
    const TomlRange bend = {modulus.from * 1e9 * area_moment_m4(outer.from, inner.from),
                            modulus.to * 1e9 * area_moment_m4(outer.to, inner.to)};
    for (double value : {bend.from, bend.to}) {
        if (value >= stiffness_bounds.low && value <= stiffness_bounds.high) continue;
        values[key].fail_key(formatted("makes EI = %g N m^2, outside %g .. %g", value, stiffness_bounds.low,
                                       stiffness_bounds.high));
    }
    return bend;
}

TomlRange read_twist(const Values &values, const Section &section)
{
    const std::string key = values.which("twist_stiffness_N_m2", "twist_to_bend");
    if (key == "twist_stiffness_N_m2") return values.read(key, stiffness_bounds);
    const TomlRange ratio = values.read(key, twist_ratio_bounds);
    const TomlRange twist = {ratio.from * section.bend_N_m2.from, ratio.to * section.bend_N_m2.to};
    // The softest tips would be softer in torsion than the core allows. The function therefore raises the
    // torsional stiffness of the softest tips to the core's lower limit.
    return {std::max(twist.from, stiffness_bounds.low), std::max(twist.to, stiffness_bounds.low)};
}

void read_radii(const Values &values, InstrumentKind kind, Section &section)
{
    const TomlValue inner = values["radius_inner_mm"];
    section.radius_outer_mm = values.read("radius_outer_mm", radius_bounds);
    if (kind == InstrumentKind::wire) {
        if (inner) inner.fail("a wire is solid: 'radius_inner_mm' is for catheters");
        return;
    }
    section.radius_inner_mm = values.read("radius_inner_mm", radius_bounds);
    if (section.radius_inner_mm.from >= section.radius_outer_mm.from ||
        section.radius_inner_mm.to >= section.radius_outer_mm.to) {
        inner.fail("'radius_inner_mm' is not below 'radius_outer_mm'");
    }
}

void read_friction(const Values &values, Section &section)
{
    section.kinetic = values.read("friction_kinetic", share_bounds);
    section.statical = values.read("friction_static", share_bounds);
    if (section.statical.from < section.kinetic.from || section.statical.to < section.kinetic.to) {
        values["friction_static"].fail("'friction_static' is below 'friction_kinetic'");
    }
}

void read_layers(const Values &values, Section &section)
{
    const std::string wanted = "must be a list of { material, fill, radius_share, source }";
    const TomlValue xray = values["xray"];
    if (!xray) values.missing("'xray'");
    if (!xray.is_list()) xray.fail_key(wanted);
    for (const TomlValue &item : xray.list()) {
        if (!item.is_table()) item.fail_key(wanted);
        const TomlTable entry = item.table().inside("'xray'");
        entry.check_keys({"material", "fill", "radius_share", "source"});
        entry.check_source();
        InstrumentLayer layer;
        layer.arc_begin_m = section.from_mm * 1e-3;
        layer.arc_end_m = section.to_mm * 1e-3;
        layer.material = entry.words("material");
        layer.fill = entry.number("fill", share_bounds);
        layer.radius_share = entry.number("radius_share", share_bounds, layer.radius_share);
        section.layers.push_back(layer);
    }
}

Section read_section(const TomlTable &table, const std::optional<TomlTable> &all, double from_mm,
                     InstrumentKind kind)
{
    table.check_keys(with({"name", "to_mm", "steps"}));
    Section section{table.words("name"), table, from_mm};
    section.to_mm = table["to_mm"].number();
    if (!(section.to_mm > from_mm))
        table["to_mm"].fail_key(
            formatted("= %g is not beyond the section's begin at %g mm", section.to_mm, from_mm));
    table.number("to_mm", {0.0, length_max_mm});
    if (table.has("steps")) section.steps = table.whole("steps", {1, 16});
    const Values values(table, all);
    read_radii(values, kind, section);
    section.bend_N_m2 = read_bend(values, section);
    section.twist_N_m2 = read_twist(values, section);
    section.mass_kg_per_m = values.read("mass_kg_per_m", mass_bounds);
    read_friction(values, section);
    read_layers(values, section);
    return section;
}

// In [[shape]], a straight piece has a length. A bent piece of [[shape]] has an angle, and either the radius
// of its centreline or the length over which the piece bends.
InstrumentArc read_arc(const TomlTable &table, double begin_m)
{
    table.check_keys({"name", "length_mm", "radius_mm", "angle_deg", "plane_deg", "source"});
    table.check_source();
    const auto read = [&](const char *key, NumberRange bounds) -> std::optional<double> {
        return table.has(key) ? std::optional(table.number(key, bounds)) : std::nullopt;
    };
    const std::optional<double> length_mm = read("length_mm", {0.1, length_max_mm});
    const std::optional<double> radius_mm = read("radius_mm", {1.0, 1000.0});
    const std::optional<double> angle_deg = read("angle_deg", {-turn_max_deg, turn_max_deg});
    const double plane_rad = table.number("plane_deg", {-180.0, 180.0}, 0.0) * rad_per_deg;
    if (!(angle_deg ? length_mm.has_value() != radius_mm.has_value() : length_mm && !radius_mm))
        table.fail(
            "must have 'length_mm' alone (straight), or 'angle_deg' with either 'radius_mm' or 'length_mm'");
    const double turn = angle_deg.value_or(0.0) * rad_per_deg;
    const double length_m = (length_mm ? *length_mm : *radius_mm * std::abs(turn)) * 1e-3;
    if (!(length_m > 0.0)) table["angle_deg"].fail("has no length: 'angle_deg' is 0");
    const double per_m = turn / length_m;
    if (std::abs(per_m) > curvature_max_per_m)
        table.fail(formatted("bends to a radius of %g mm; at least 1 mm", 1e3 / std::abs(per_m)));
    return {table.words("name"), begin_m, begin_m + length_m, per_m * std::cos(plane_rad),
            per_m * std::sin(plane_rad)};
}

// Returns a text such as "section 2 'taper'", with which messages identify one of several tables that have
// the same key.
std::string title_of(const char *kind, std::size_t index, const TomlTable &table)
{
    const TomlValue name = table["name"];
    return kind + (" " + std::to_string(index + 1)) + (name.is_text() ? " " + in_quotes(name.text()) : "");
}

} // namespace

std::vector<Section> read_sections(const TomlTable &preset, InstrumentKind kind)
{
    std::optional<TomlTable> all;
    if (preset.has("all")) {
        all = preset.table("all").inside("[all]");
        all->check_keys(property_keys);
    }
    const std::vector<TomlTable> tables = preset.tables("section");
    if (tables.empty()) preset.fail("there must be at least one section");
    std::vector<Section> sections;
    for (const TomlTable &table : tables) {
        const double from_mm = sections.empty() ? 0.0 : sections.back().to_mm;
        sections.push_back(
            read_section(table.inside(title_of("section", sections.size(), table)), all, from_mm, kind));
    }
    return sections;
}

std::vector<InstrumentArc> read_shape(const TomlTable &root)
{
    std::vector<InstrumentArc> arcs;
    for (const TomlTable &table : root.tables("shape")) {
        const double begin_m = arcs.empty() ? 0.0 : arcs.back().arc_end_m;
        arcs.push_back(read_arc(table.inside(title_of("shape", arcs.size(), table)), begin_m));
    }
    return arcs;
}

std::vector<SideHoles> read_side_holes(const TomlTable &root, InstrumentKind kind)
{
    constexpr NumberRange place_mm = {0.0, length_max_mm};
    std::vector<SideHoles> groups;
    for (const TomlTable &table : root.tables("side_holes")) {
        const TomlTable inner = table.inside("side_holes " + std::to_string(groups.size() + 1));
        if (kind != InstrumentKind::catheter)
            inner.fail("a wire has no lumen: 'side_holes' is for catheters");
        inner.check_keys({"from_mm", "to_mm", "count", "diameter_mm", "source"});
        inner.check_source();
        const SideHoles holes = {inner.number("from_mm", place_mm) * 1e-3,
                                 inner.number("to_mm", place_mm) * 1e-3,
                                 static_cast<std::uint32_t>(inner.whole("count", {1, 40})),
                                 inner.number("diameter_mm", {0.1, 2.0}) * 1e-3};
        if (holes.arc_end_m < holes.arc_begin_m) inner["to_mm"].fail("'to_mm' is below 'from_mm'");
        groups.push_back(holes);
    }
    return groups;
}

void read_elements(const TomlTable &root, crn_wire_instrument &wire)
{
    const TomlTable table = root.table("elements").inside("elements");
    table.check_keys({"tip_mm", "fine_mm", "shaft_mm", "axial_stiffness_max_N"});
    const auto read = [&](const char *key, NumberRange bounds, double scale) {
        return static_cast<std::uint32_t>(std::lround(table.sourced(key, bounds) * scale));
    };
    wire.element_tip_um = read("tip_mm", {0.2, 8.0}, 1e3);
    wire.element_fine_um = read("fine_mm", {0.0, length_max_mm}, 1e3);
    wire.element_shaft_um = read("shaft_mm", {0.2, 8.0}, 1e3);
    wire.axial_stiffness_max_N = read("axial_stiffness_max_N", {100.0, 10000.0}, 1.0);
    if (wire.element_shaft_um < wire.element_tip_um) table["shaft_mm"].fail("'shaft_mm' is below 'tip_mm'");
}

} // namespace crn::instrument_file
