// Reads [[section]], [all], [[shape]] and [elements] of an instrument file. The limits are those of the core
// (firmware/core/core.h).
#include "host/model/instrument_parts.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace crn::instrument_file
{

namespace
{

constexpr Bounds modulus_GPa_bounds = {1e-3, 250.0};
constexpr Bounds twist_ratio_bounds = {0.05, 5.0};
constexpr Bounds mass_bounds = {5e-4, 0.1};
constexpr Bounds share_bounds = {0.0, 1.0};
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

// Reads the values of a section; where one is missing, the value of [all] applies.
class Values
{
  public:
    Values(const Place &place, const toml::table &own, const toml::table *all)
        : place_(place), own_(own), all_(all)
    {
    }

    const toml::node *find(const std::string &key) const
    {
        if (const toml::node *node = own_.get(key)) return node;
        return all_ ? all_->get(key) : nullptr;
    }

    Range read(const std::string &key, Bounds bounds) const
    {
        const toml::node *node = find(key);
        if (!node) missing(in_quotes(key));
        return sourced(place_, *node, key, bounds);
    }

    // Returns which of two mutually exclusive keys is given; the section's own takes precedence over that of
    // [all].
    std::string which(const std::string &a, const std::string &b) const
    {
        for (const toml::table *table : {&own_, all_}) {
            if (!table) continue;
            if (table->contains(a) && table->contains(b)) {
                fail(place_, table->get(b), "gives both " + in_quotes(a) + " and " + in_quotes(b));
            }
            if (table->contains(a)) return a;
            if (table->contains(b)) return b;
        }
        missing(in_quotes(a) + " or " + in_quotes(b));
    }

    const Place &place() const { return place_; }
    const toml::table &own() const { return own_; }

  private:
    [[noreturn]] void missing(const std::string &what) const
    {
        fail(place_, &own_, what + " is missing, here and in [all]");
    }

    const Place &place_;
    const toml::table &own_;
    const toml::table *all_;
};

// Returns pi/4 (R^4 - r^4), the second moment of area of a tube or, with r = 0, of a round wire; mm -> m^4.
double area_moment_m4(double outer_mm, double inner_mm)
{
    return std::numbers::pi / 4.0 * (std::pow(outer_mm, 4) - std::pow(inner_mm, 4)) * 1e-12;
}

Range read_bend(const Values &values, const Section &section)
{
    const std::string key = values.which("bend_stiffness_N_m2", "flexural_modulus_GPa");
    if (key == "bend_stiffness_N_m2") return values.read(key, stiffness_bounds);
    const Range modulus = values.read(key, modulus_GPa_bounds);
    const Range &outer = section.radius_outer_mm, &inner = section.radius_inner_mm;
    const Range bend = {modulus.from * 1e9 * area_moment_m4(outer.from, inner.from),
                        modulus.to * 1e9 * area_moment_m4(outer.to, inner.to)};
    for (double value : {bend.from, bend.to}) {
        if (value >= stiffness_bounds.low && value <= stiffness_bounds.high) continue;
        fail(values.place(), values.find(key),
             in_quotes(key) + " makes EI = " + number(value) + " N m^2, outside " +
                 number(stiffness_bounds.low) + " .. " + number(stiffness_bounds.high));
    }
    return bend;
}

Range read_twist(const Values &values, const Section &section)
{
    const std::string key = values.which("twist_stiffness_N_m2", "twist_to_bend");
    if (key == "twist_stiffness_N_m2") return values.read(key, stiffness_bounds);
    const Range ratio = values.read(key, twist_ratio_bounds);
    const Range twist = {ratio.from * section.bend_N_m2.from, ratio.to * section.bend_N_m2.to};
    // The softest tips would be softer in torsion than the core allows, so they get the core's limit.
    return {std::max(twist.from, stiffness_bounds.low), std::max(twist.to, stiffness_bounds.low)};
}

void read_radii(const Values &values, InstrumentKind kind, Section &section)
{
    const toml::node *inner = values.find("radius_inner_mm");
    section.radius_outer_mm = values.read("radius_outer_mm", radius_bounds);
    if (kind == InstrumentKind::wire) {
        if (inner) fail(values.place(), inner, "a wire is solid: 'radius_inner_mm' is for catheters");
        return;
    }
    section.radius_inner_mm = values.read("radius_inner_mm", radius_bounds);
    if (section.radius_inner_mm.from >= section.radius_outer_mm.from ||
        section.radius_inner_mm.to >= section.radius_outer_mm.to) {
        fail(values.place(), inner, "'radius_inner_mm' is not below 'radius_outer_mm'");
    }
}

void read_friction(const Values &values, Section &section)
{
    section.kinetic = values.read("friction_kinetic", share_bounds);
    section.statical = values.read("friction_static", share_bounds);
    if (section.statical.from < section.kinetic.from || section.statical.to < section.kinetic.to) {
        fail(values.place(), values.find("friction_static"), "'friction_static' is below 'friction_kinetic'");
    }
}

void read_layers(const Values &values, Section &section)
{
    const std::string wanted = "'xray' must be a list of { material, fill, radius_share, source }";
    const toml::node *node = values.find("xray");
    if (!node) fail(values.place(), &values.own(), "'xray' is missing, here and in [all]");
    const toml::array *list = node->as_array();
    if (!list) fail(values.place(), node, wanted);
    for (const toml::node &item : *list) {
        const toml::table *entry = item.as_table();
        if (!entry) fail(values.place(), &item, wanted);
        const Place place = values.place().inside("'xray'");
        check_keys(place, *entry, {"material", "fill", "radius_share", "source"});
        check_source(place, *entry);
        InstrumentLayer layer;
        layer.arc_begin_m = section.from_mm * 1e-3;
        layer.arc_end_m = section.to_mm * 1e-3;
        layer.material = to_text(place, require(place, *entry, "material"), "material");
        layer.fill = to_number(place, require(place, *entry, "fill"), "fill");
        check_bounds(place, item, "fill", layer.fill, share_bounds);
        if (const toml::node *share = entry->get("radius_share")) {
            layer.radius_share = to_number(place, *share, "radius_share");
            check_bounds(place, *share, "radius_share", layer.radius_share, share_bounds);
        }
        section.layers.push_back(layer);
    }
}

Section read_section(const Place &place, const toml::table &table, const toml::table *all, double from_mm,
                     InstrumentKind kind)
{
    check_keys(place, table, with({"name", "to_mm", "steps"}));
    Section section;
    section.name = to_text(place, require(place, table, "name"), "name");
    section.node = &table;
    section.from_mm = from_mm;
    const toml::node &end = require(place, table, "to_mm");
    section.to_mm = to_number(place, end, "to_mm");
    if (!(section.to_mm > from_mm)) {
        fail(place, &end,
             "'to_mm' = " + number(section.to_mm) + " is not beyond the section's begin at " +
                 number(from_mm) + " mm");
    }
    check_bounds(place, end, "to_mm", section.to_mm, {0.0, length_max_mm});
    if (const toml::node *node = table.get("steps")) {
        const double steps = to_number(place, *node, "steps");
        check_bounds(place, *node, "steps", steps, {1, 16});
        if (steps != std::floor(steps)) fail(place, node, "'steps' is not a whole number");
        section.steps = static_cast<int>(steps);
    }
    const Values values(place, table, all);
    read_radii(values, kind, section);
    section.bend_N_m2 = read_bend(values, section);
    section.twist_N_m2 = read_twist(values, section);
    section.mass_kg_per_m = values.read("mass_kg_per_m", mass_bounds);
    read_friction(values, section);
    read_layers(values, section);
    return section;
}

// A straight piece of [[shape]] has a length. A bent piece has an angle, and either the radius of its
// centreline or the length over which it bends.
InstrumentArc read_arc(const Place &place, const toml::table &table, double begin_m)
{
    check_keys(place, table, {"name", "length_mm", "radius_mm", "angle_deg", "plane_deg", "source"});
    check_source(place, table);
    auto read = [&](const char *key, Bounds bounds) -> std::optional<double> {
        const toml::node *node = table.get(key);
        if (!node) return std::nullopt;
        const double value = to_number(place, *node, key);
        check_bounds(place, *node, key, value, bounds);
        return value;
    };
    const std::optional<double> length_mm = read("length_mm", {0.1, length_max_mm});
    const std::optional<double> radius_mm = read("radius_mm", {1.0, 1000.0});
    const std::optional<double> angle_deg = read("angle_deg", {-turn_max_deg, turn_max_deg});
    const double plane_rad = read("plane_deg", {-180.0, 180.0}).value_or(0.0) * rad_per_deg;
    if (!(angle_deg ? length_mm.has_value() != radius_mm.has_value() : length_mm && !radius_mm)) {
        fail(place, &table,
             "must have 'length_mm' alone (straight), or 'angle_deg' with either 'radius_mm' or 'length_mm'");
    }
    const double turn = angle_deg.value_or(0.0) * rad_per_deg;
    const double length_m = (length_mm ? *length_mm : *radius_mm * std::abs(turn)) * 1e-3;
    if (!(length_m > 0.0)) fail(place, table.get("angle_deg"), "has no length: 'angle_deg' is 0");
    const double per_m = turn / length_m;
    if (std::abs(per_m) > curvature_max_per_m) {
        fail(place, &table, "bends to a radius of " + number(1e3 / std::abs(per_m)) + " mm; at least 1 mm");
    }
    return {to_text(place, require(place, table, "name"), "name"), begin_m, begin_m + length_m,
            per_m * std::cos(plane_rad), per_m * std::sin(plane_rad)};
}

} // namespace

std::vector<Section> read_sections(const Place &place, const toml::table &preset, InstrumentKind kind)
{
    const toml::table *all = nullptr;
    if (preset.contains("all")) {
        all = &require_table(place, preset, "all");
        check_keys(place.inside("[all]"), *all, property_keys);
    }
    const std::vector<const toml::table *> tables = tables_of(place, preset, "section");
    if (tables.empty()) fail(place, &preset, "there must be at least one section");
    std::vector<Section> sections;
    for (const toml::table *table : tables) {
        std::string title = "section " + std::to_string(sections.size() + 1);
        if (const auto name = (*table)["name"].value<std::string>()) title += " " + in_quotes(*name);
        const double from_mm = sections.empty() ? 0.0 : sections.back().to_mm;
        sections.push_back(read_section(place.inside(title), *table, all, from_mm, kind));
    }
    return sections;
}

std::vector<InstrumentArc> read_shape(const Place &place, const toml::table &root)
{
    std::vector<InstrumentArc> arcs;
    for (const toml::table *table : tables_of(place, root, "shape")) {
        std::string title = "shape " + std::to_string(arcs.size() + 1);
        if (const auto name = (*table)["name"].value<std::string>()) title += " " + in_quotes(*name);
        const double begin_m = arcs.empty() ? 0.0 : arcs.back().arc_end_m;
        arcs.push_back(read_arc(place.inside(title), *table, begin_m));
    }
    return arcs;
}

std::vector<SideHoles> read_side_holes(const Place &place, const toml::table &root, InstrumentKind kind)
{
    constexpr Bounds place_mm = {0.0, length_max_mm}, count_bounds = {1.0, 40.0}, diameter_mm = {0.1, 2.0};
    std::vector<SideHoles> groups;
    for (const toml::table *table : tables_of(place, root, "side_holes")) {
        const Place inner = place.inside("side_holes " + std::to_string(groups.size() + 1));
        if (kind != InstrumentKind::catheter)
            fail(inner, table, "a wire has no lumen: 'side_holes' is for catheters");
        check_keys(inner, *table, {"from_mm", "to_mm", "count", "diameter_mm", "source"});
        check_source(inner, *table);
        const auto read = [&](const char *key, Bounds bounds) {
            const toml::node &node = require(inner, *table, key);
            const double value = to_number(inner, node, key);
            check_bounds(inner, node, key, value, bounds);
            return value;
        };
        const SideHoles holes = {read("from_mm", place_mm) * 1e-3, read("to_mm", place_mm) * 1e-3,
                                 static_cast<std::uint32_t>(std::lround(read("count", count_bounds))),
                                 read("diameter_mm", diameter_mm) * 1e-3};
        if (holes.arc_end_m < holes.arc_begin_m)
            fail(inner, table->get("to_mm"), "'to_mm' is below 'from_mm'");
        groups.push_back(holes);
    }
    return groups;
}

void read_elements(const Place &place, const toml::table &root, crn_wire_instrument &wire)
{
    const toml::table &table = require_table(place, root, "elements");
    const Place inner = place.inside("elements");
    check_keys(inner, table, {"tip_mm", "fine_mm", "shaft_mm", "axial_stiffness_max_N"});
    auto read = [&](const char *key, Bounds bounds, double scale) {
        return static_cast<std::uint32_t>(std::lround(sourced_value(inner, table, key, bounds) * scale));
    };
    wire.element_tip_um = read("tip_mm", {0.2, 8.0}, 1e3);
    wire.element_fine_um = read("fine_mm", {0.0, length_max_mm}, 1e3);
    wire.element_shaft_um = read("shaft_mm", {0.2, 8.0}, 1e3);
    wire.axial_stiffness_max_N = read("axial_stiffness_max_N", {100.0, 10000.0}, 1.0);
    if (wire.element_shaft_um < wire.element_tip_um) {
        fail(inner, table.get("shaft_mm"), "'shaft_mm' is below 'tip_mm'");
    }
}

} // namespace crn::instrument_file
