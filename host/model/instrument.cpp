#include "host/model/instrument.hpp"
#include "host/model/text.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <toml++/toml.h>

namespace seld
{

namespace
{

struct Range {
    double from = 0.0, to = 0.0;
};

// Where an error is: file and the section's name.
struct Place {
    const std::string &file;
    std::string where; // "section 2 'transition'"
};

[[noreturn]] void fail(const Place &place, const toml::node *node, const std::string &text)
{
    const int line = node ? static_cast<int>(node->source().begin.line) : 0;
    const int column = node ? static_cast<int>(node->source().begin.column) : 0;
    throw FileError(place.file, line, column, (place.where.empty() ? "" : place.where + ": ") + text);
}

std::string number(double value)
{
    char text[40];
    std::snprintf(text, sizeof text, "%g", value);
    return text;
}

void check_keys(const Place &place, const toml::table &table, const std::vector<std::string> &known)
{
    for (const auto &[key, node] : table) {
        const std::string name(key.str());
        if (std::find(known.begin(), known.end(), name) == known.end()) {
            fail(place, &node, "unknown key '" + name + "'" + suggestion(name, known));
        }
    }
}

const toml::node &require(const Place &place, const toml::table &table, const char *key)
{
    const toml::node *node = table.get(key);
    if (!node) fail(place, &table, std::string("'") + key + "' is missing");
    return *node;
}

double to_number(const Place &place, const toml::node &node, const char *key)
{
    const std::optional<double> value = node.value<double>();
    if (!value || !std::isfinite(*value))
        fail(place, &node, std::string("'") + key + "' is not a finite number");
    return *value;
}

std::string to_text(const Place &place, const toml::node &node, const char *key)
{
    const std::optional<std::string> value = node.value_exact<std::string>();
    if (!value || value->empty()) fail(place, &node, std::string("'") + key + "' is not a text");
    return *value;
}

void check_range(const Place &place, const toml::node &node, const char *key, double value, double low,
                 double high)
{
    if (value < low || value > high) {
        fail(place, &node,
             std::string("'") + key + "' = " + number(value) + " is outside " + number(low) + " .. " +
                 number(high));
    }
}

// { value, source } or { from, to, source }: a source is compulsory, so that no figure is without an origin.
Range sourced(const Place &place, const toml::table &table, const char *key, double low, double high)
{
    const toml::node &node = require(place, table, key);
    const toml::table *entry = node.as_table();
    if (!entry) {
        fail(place, &node,
             std::string("'") + key +
                 "' must be { value = ..., source = \"...\" } or { from = ..., to = ..., source = \"...\" }");
    }
    const Place inner{place.file, (place.where.empty() ? "" : place.where + ": ") + "'" + key + "'"};
    check_keys(inner, *entry, {"value", "from", "to", "source"});
    to_text(inner, require(inner, *entry, "source"), "source");
    const bool is_constant = entry->contains("value");
    if (is_constant && (entry->contains("from") || entry->contains("to"))) {
        fail(inner, &node, "has both 'value' and 'from'/'to'");
    }
    Range range;
    range.from = to_number(inner, require(inner, *entry, is_constant ? "value" : "from"), key);
    range.to = is_constant ? range.from : to_number(inner, require(inner, *entry, "to"), key);
    check_range(place, node, key, range.from, low, high);
    check_range(place, node, key, range.to, low, high);
    return range;
}

// At share u of a section. Positive values change by equal ratios (a ground taper spans decades), others linearly.
double at(const Range &range, double u)
{
    if (range.from > 0.0 && range.to > 0.0 && range.from != range.to) {
        return range.from * std::pow(range.to / range.from, u);
    }
    return range.from + (range.to - range.from) * u;
}

struct Section {
    double from_mm = 0.0, to_mm = 0.0;
    int steps = 1;
    Range bend_N_m2, twist_N_m2, mass_kg_per_m, radius_mm, kinetic, statical, curvature_per_m;
};

const std::vector<std::string> section_keys = {"name",
                                               "from_mm",
                                               "to_mm",
                                               "steps",
                                               "bend_stiffness_N_m2",
                                               "twist_stiffness_N_m2",
                                               "mass_kg_per_m",
                                               "radius_outer_mm",
                                               "friction_kinetic",
                                               "friction_static",
                                               "rest_curvature_per_m",
                                               "xray"};

void read_layers(const Place &place, const toml::table &table, const Section &section, Instrument &instrument)
{
    const toml::node &node = require(place, table, "xray");
    const toml::array *list = node.as_array();
    if (!list) fail(place, &node, "'xray' must be a list of { material, fill, radius_share, source }");
    for (const toml::node &item : *list) {
        const toml::table *entry = item.as_table();
        if (!entry) fail(place, &item, "'xray' must be a list of { material, fill, radius_share, source }");
        check_keys(place, *entry, {"material", "fill", "radius_share", "source"});
        InstrumentLayer layer;
        layer.arc_begin_m = section.from_mm * 1e-3;
        layer.arc_end_m = section.to_mm * 1e-3;
        layer.material = to_text(place, require(place, *entry, "material"), "material");
        layer.fill = to_number(place, require(place, *entry, "fill"), "fill");
        layer.radius_share = to_number(place, require(place, *entry, "radius_share"), "radius_share");
        check_range(place, item, "fill", layer.fill, 0.0, 1.0);
        check_range(place, item, "radius_share", layer.radius_share, 0.0, 1.0);
        to_text(place, require(place, *entry, "source"), "source");
        instrument.layers.push_back(layer);
    }
}

// Ranges are those of the core (firmware/core/core.h, seld_knot).
Section read_section(const Place &place, const toml::table &table)
{
    check_keys(place, table, section_keys);
    Section section;
    section.from_mm = to_number(place, require(place, table, "from_mm"), "from_mm");
    section.to_mm = to_number(place, require(place, table, "to_mm"), "to_mm");
    check_range(place, table, "from_mm", section.from_mm, 0.0, 1600.0);
    check_range(place, table, "to_mm", section.to_mm, 0.0, 1600.0);
    if (!(section.to_mm > section.from_mm)) fail(place, &table, "'to_mm' is not beyond 'from_mm'");
    if (const toml::node *node = table.get("steps")) {
        const double steps = to_number(place, *node, "steps");
        check_range(place, *node, "steps", steps, 1, 16);
        section.steps = static_cast<int>(steps);
    }
    section.bend_N_m2 = sourced(place, table, "bend_stiffness_N_m2", 1e-7, 3e-2);
    section.twist_N_m2 = sourced(place, table, "twist_stiffness_N_m2", 1e-7, 3e-2);
    section.mass_kg_per_m = sourced(place, table, "mass_kg_per_m", 5e-4, 0.1);
    section.radius_mm = sourced(place, table, "radius_outer_mm", 0.1, 2.0);
    section.kinetic = sourced(place, table, "friction_kinetic", 0.0, 1.0);
    section.statical = sourced(place, table, "friction_static", 0.0, 1.0);
    section.curvature_per_m = sourced(place, table, "rest_curvature_per_m", -1000.0, 1000.0);
    return section;
}

std::uint32_t rounded(double value)
{
    return static_cast<std::uint32_t>(std::lround(value));
}

seld_wire_knot knot_at(const Section &section, double u)
{
    seld_wire_knot knot{};
    knot.arc_um = rounded((section.from_mm + (section.to_mm - section.from_mm) * u) * 1e3);
    knot.bend_stiffness_nN_m2 = rounded(at(section.bend_N_m2, u) * 1e9);
    knot.twist_stiffness_nN_m2 = rounded(at(section.twist_N_m2, u) * 1e9);
    knot.mass_mg_per_m = rounded(at(section.mass_kg_per_m, u) * 1e6);
    knot.radius_outer_um = rounded(at(section.radius_mm, u) * 1e3);
    knot.friction_kinetic_milli = rounded(at(section.kinetic, u) * 1e3);
    knot.friction_static_milli = rounded(at(section.statical, u) * 1e3);
    knot.rest_curvature1_per_m_milli =
        static_cast<std::int32_t>(std::lround(at(section.curvature_per_m, u) * 1e3));
    return knot;
}

void add_knots(const Place &place, const toml::table &table, const Section &section,
               seld_wire_instrument &wire)
{
    for (int i = 0; i <= section.steps; i++) {
        const seld_wire_knot knot = knot_at(section, static_cast<double>(i) / section.steps);
        if (knot.friction_static_milli < knot.friction_kinetic_milli) {
            fail(place, &table, "'friction_static' is below 'friction_kinetic'");
        }
        if (wire.knots_count == SELD_WIRE_MAX_instrument_knots) {
            fail(place, &table,
                 "the profile needs more than " + std::to_string(SELD_WIRE_MAX_instrument_knots) +
                     " knots (each section takes steps + 1); use fewer steps");
        }
        wire.knots[wire.knots_count++] = knot;
    }
}

void read_sections(const Place &place, const toml::table &root, Instrument &instrument)
{
    const toml::node &node = require(place, root, "section");
    const toml::array *list = node.as_array();
    if (!list || list->empty()) fail(place, &node, "there must be at least one [[section]]");
    double end_mm = 0.0;
    int count = 0;
    for (const toml::node &item : *list) {
        Place inner{place.file, "section " + std::to_string(++count)};
        const toml::table *table = item.as_table();
        if (!table) fail(inner, &item, "must be a [[section]] table");
        inner.where += " '" + to_text(inner, require(inner, *table, "name"), "name") + "'";
        const Section section = read_section(inner, *table);
        if (section.from_mm != end_mm) {
            fail(inner, table->get("from_mm"),
                 "'from_mm' = " + number(section.from_mm) +
                     " leaves a gap or overlap: the section before ends at " + number(end_mm));
        }
        end_mm = section.to_mm;
        add_knots(inner, *table, section, instrument.table);
        read_layers(inner, *table, section, instrument);
    }
    instrument.length_m = end_mm * 1e-3;
}

void read_elements(const Place &place, const toml::table &root, seld_wire_instrument &wire)
{
    const toml::node &node = require(place, root, "elements");
    const toml::table *table = node.as_table();
    const Place inner{place.file, "elements"};
    if (!table) fail(inner, &node, "must be an [elements] table");
    check_keys(inner, *table, {"tip_mm", "fine_mm", "shaft_mm", "axial_stiffness_max_N"});
    wire.element_tip_um = rounded(sourced(inner, *table, "tip_mm", 0.2, 8.0).from * 1e3);
    wire.element_fine_um = rounded(sourced(inner, *table, "fine_mm", 0.0, 1600.0).from * 1e3);
    wire.element_shaft_um = rounded(sourced(inner, *table, "shaft_mm", 0.2, 8.0).from * 1e3);
    wire.axial_stiffness_max_N =
        rounded(sourced(inner, *table, "axial_stiffness_max_N", 100.0, 10000.0).from);
    if (wire.element_shaft_um < wire.element_tip_um) fail(inner, table, "'shaft_mm' is below 'tip_mm'");
}

} // namespace

Instrument read_instrument(const std::string &path)
{
    const std::string text = read_text_file(path);
    toml::table root;
    try {
        root = toml::parse(text, path);
    } catch (const toml::parse_error &error) {
        throw FileError(path, static_cast<int>(error.source().begin.line),
                        static_cast<int>(error.source().begin.column), std::string(error.description()));
    }
    const Place place{path, ""};
    check_keys(place, root, {"format", "name", "description", "elements", "section"});
    const toml::node &format = require(place, root, "format");
    if (format.value<std::int64_t>() != 1)
        fail(place, &format, "'format' must be 1; this file is of another version");
    Instrument instrument;
    instrument.name = to_text(place, require(place, root, "name"), "name");
    read_elements(place, root, instrument.table);
    read_sections(place, root, instrument);
    return instrument;
}

} // namespace seld
