#include "tools/lab/calibrate/fitted_instrument.hpp"
#include "host/base/toml.hpp"
#include "host/base/toml_reader.hpp"
#include <cmath>
#include <set>
#include <sstream>

namespace crn::calibrate
{
namespace
{

// The following keys of an instrument file have values that a fit determines.
const char *const replaced_keys[] = {"bend_stiffness_N_m2", "flexural_modulus_GPa", "twist_stiffness_N_m2",
                                     "twist_to_bend",       "mass_kg_per_m",        "radius_outer_mm",
                                     "friction_kinetic",    "friction_static"};

toml::table value_of(double from, double to, const std::string &source)
{
    toml::table value;
    value.is_inline(true);
    if (from == to) {
        value.insert("value", from);
    } else {
        value.insert("from", from);
        value.insert("to", to);
    }
    value.insert("source", source);
    return value;
}

// Converts a whole number of the wire protocol's small units to a decimal number in the units of an
// instrument file. For example, 14500 nN m^2 becomes 1.45e-05, which is read back exactly.
double decimal(std::uint32_t value, double units)
{
    return static_cast<double>(value) / units;
}

void fill_section(toml::table &section, const crn_wire_knot &begin, const crn_wire_knot &end,
                  const std::string &source)
{
    for (const char *key : replaced_keys) section.erase(key);
    const auto put = [&](const char *key, std::uint32_t from, std::uint32_t to, double units) {
        section.insert(key, value_of(decimal(from, units), decimal(to, units), source));
    };
    put("bend_stiffness_N_m2", begin.bend_stiffness_nN_m2, end.bend_stiffness_nN_m2, 1e9);
    put("twist_stiffness_N_m2", begin.twist_stiffness_nN_m2, end.twist_stiffness_nN_m2, 1e9);
    put("mass_kg_per_m", begin.mass_mg_per_m, end.mass_mg_per_m, 1e6);
    put("radius_outer_mm", begin.radius_outer_um, end.radius_outer_um, 1e3);
    put("friction_kinetic", begin.friction_kinetic_milli, end.friction_kinetic_milli, 1e3);
    put("friction_static", begin.friction_static_milli, end.friction_static_milli, 1e3);
}

// Collects the names of the sources that an instrument file cites as "@name" or "@name: more".
void gather_names(const toml::node &node, std::set<std::string> &names)
{
    if (const toml::table *table = node.as_table()) {
        if (const auto source = (*table)["source"].value<std::string>(); source && (*source)[0] == '@')
            names.insert(source->substr(1, source->find(':') - 1));
        for (const auto &[key, inner] : *table) gather_names(inner, names);
    }
    if (const toml::array *array = node.as_array())
        for (const toml::node &inner : *array) gather_names(inner, names);
}

void drop_unused_sources(toml::table &root)
{
    toml::table *sources = root["sources"].as_table();
    if (!sources) return;
    std::set<std::string> names;
    gather_names(root, names);
    std::vector<std::string> unused;
    for (const auto &[key, node] : *sources)
        if (!names.contains(std::string(key.str()))) unused.emplace_back(key.str());
    for (const std::string &name : unused) sources->erase(name);
    if (sources->empty()) root.erase("sources");
}

} // namespace

crn_wire_knot knot_at(const crn_wire_instrument &table, double arc_mm, bool is_after)
{
    const double arc_um = arc_mm * 1e3, same_um = 0.5;
    unsigned next = 0; // first knot behind the place
    while (next < table.knots_count && (table.knots[next].arc_um < arc_um - same_um ||
                                        (is_after && table.knots[next].arc_um < arc_um + same_um)))
        next++;
    if (next == 0) return table.knots[0];
    const crn_wire_knot &from = table.knots[next - 1];
    if (next == table.knots_count) return from;
    const crn_wire_knot &to = table.knots[next];
    const double length_um = double(to.arc_um) - from.arc_um;
    const double share = length_um > 0.0 ? (arc_um - from.arc_um) / length_um : 1.0;
    const auto between = [share](auto a, auto b) {
        return static_cast<decltype(a)>(std::llround(double(a) + share * (double(b) - double(a))));
    };
    return {.arc_um = static_cast<std::uint32_t>(std::llround(arc_um)),
            .bend_stiffness_nN_m2 = between(from.bend_stiffness_nN_m2, to.bend_stiffness_nN_m2),
            .twist_stiffness_nN_m2 = between(from.twist_stiffness_nN_m2, to.twist_stiffness_nN_m2),
            .mass_mg_per_m = between(from.mass_mg_per_m, to.mass_mg_per_m),
            .radius_outer_um = between(from.radius_outer_um, to.radius_outer_um),
            .radius_inner_um = between(from.radius_inner_um, to.radius_inner_um),
            .friction_kinetic_milli = between(from.friction_kinetic_milli, to.friction_kinetic_milli),
            .friction_static_milli = between(from.friction_static_milli, to.friction_static_milli),
            .rest_curvature1_per_m_milli =
                between(from.rest_curvature1_per_m_milli, to.rest_curvature1_per_m_milli),
            .rest_curvature2_per_m_milli =
                between(from.rest_curvature2_per_m_milli, to.rest_curvature2_per_m_milli)};
}

std::string fitted_instrument_text(const std::string &nominal, const crn_wire_instrument &fitted,
                                   const std::string &source)
{
    const auto [file, asked] = split_preset(nominal);
    toml::table root = read_toml_tree(file, {"an instrument", "the nominal instrument's file"});
    const std::string preset_name = asked.empty() ? "physical" : asked;
    const toml::table *preset = root["preset"][preset_name].as_table();
    if (!preset || !(*preset)["section"].as_array())
        throw FileError(file, 0, 0,
                        "preset '" + preset_name +
                            "' has no sections of its own to put fitted numbers into; calibrate 'physical'");
    toml::table own = *preset;
    if (toml::table *all = own["all"].as_table())
        for (const char *key : replaced_keys) all->erase(key);
    double from_mm = 0.0;
    for (toml::node &node : *own["section"].as_array()) {
        toml::table &section = *node.as_table();
        const double to_mm = section["to_mm"].value_or(0.0);
        fill_section(section, knot_at(fitted, from_mm, true), knot_at(fitted, to_mm, false), source);
        from_mm = to_mm;
    }
    own.insert_or_assign("description", source);
    toml::table presets;
    presets.insert("physical", own);
    root.insert_or_assign("preset", presets);
    root.insert_or_assign("name", root["name"].value_or(std::string("instrument")) + ", fitted");
    drop_unused_sources(root);
    std::ostringstream text;
    text << "# Written by `calibrate`: docs/calibrate.md\n" << root << "\n";
    return text.str();
}

} // namespace crn::calibrate
