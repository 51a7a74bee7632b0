// Reads an instrument file as a whole: head, sources and presets. This file also makes the preset that the
// thesis' table describes.
#include "host/model/instrument.hpp"
#include "host/base/text.hpp"
#include "host/model/instrument_parts.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace crn
{

namespace
{

using namespace instrument_file;

const std::string default_preset = "physical";

toml::table parse(const std::string &file, const std::string &text)
{
    try {
        return parse_toml(text, file);
    } catch (const TomlError &error) {
        throw FileError(file, error.line, error.column, error.what());
    }
}

Sources read_sources(const Place &place, const toml::table &root)
{
    Sources sources;
    if (!root.contains("sources")) return sources;
    for (const auto &[key, node] : require_table(place, root, "sources")) {
        to_text(place.inside("sources"), node, std::string(key.str()));
        sources.add(std::string(key.str()), node);
    }
    return sources;
}

void read_head(const Place &place, const toml::table &root, Instrument &instrument)
{
    check_keys(place, root,
               {"format", "name", "kind", "description", "shape_name", "sources", "elements", "shape",
                "side_holes", "balloon", "preset"});
    instrument.name = to_text(place, require(place, root, "name"), "name");
    instrument.description = to_text(place, require(place, root, "description"), "description");
    instrument.shape_name = to_text(place, require(place, root, "shape_name"), "shape_name");
    const toml::node &kind = require(place, root, "kind");
    const std::string text = to_text(place, kind, "kind");
    if (text != "wire" && text != "catheter") {
        fail(place, &kind, "'kind' is '" + text + "'" + suggestion(text, {"wire", "catheter"}));
    }
    instrument.kind = text == "wire" ? InstrumentKind::wire : InstrumentKind::catheter;
}

double read_lumen_friction(const Place &place, const toml::table &table, InstrumentKind kind)
{
    if (kind == InstrumentKind::catheter) return sourced_value(place, table, "lumen_friction", {0.0, 1.0});
    if (const toml::node *node = table.get("lumen_friction")) {
        fail(place, node, "a wire has no lumen: 'lumen_friction' is for catheters");
    }
    return 0.0;
}

ThesisRow read_thesis_row(const Place &place, const toml::table &table)
{
    check_keys(place, table, {"row", "young_modulus_1e7", "radius_1e3", "density_1e5", "kp_1e3", "source"});
    check_source(place, table);
    auto read = [&](const char *key, Bounds bounds = {0.01, 1000.0}) {
        const toml::node &node = require(place, table, key);
        const double value = to_number(place, node, key);
        check_bounds(place, node, key, value, bounds);
        return value;
    };
    ThesisRow thesis;
    thesis.row = to_text(place, require(place, table, "row"), "row");
    thesis.young_modulus = read("young_modulus_1e7") * 1e7;
    thesis.radius_m = read("radius_1e3", {1.0, 20.0}) * 1e-4;
    thesis.density = read("density_1e5") * 1e5;
    thesis.kp = read("kp_1e3") * 1e3;
    return thesis;
}

Range scaled(const Range &range, double factor, Bounds bounds)
{
    return {std::clamp(range.from * factor, bounds.low, bounds.high),
            std::clamp(range.to * factor, bounds.low, bounds.high)};
}

// See docs/instruments.md, "vcsim3-fit". The shaft gets E and radius from the table. Along the instrument all
// values keep their ratio to the shaft's, as in the base preset, because the table has no tip. Mass and
// friction stay too.
void apply_thesis(const Place &place, const ThesisRow &thesis, std::vector<Section> &sections)
{
    const double factor = thesis.bend_stiffness_N_m2() / sections.back().bend_N_m2.to;
    const double radius_mm = thesis.radius_m * 1e3;
    for (Section &section : sections) {
        section.bend_N_m2 = scaled(section.bend_N_m2, factor, stiffness_bounds);
        section.twist_N_m2 = scaled(section.twist_N_m2, factor, stiffness_bounds);
        // The metal core keeps its size, so its share of the new outer radius changes.
        const double share = section.radius_outer_mm.from / radius_mm;
        for (InstrumentLayer &layer : section.layers)
            layer.radius_share = std::min(1.0, layer.radius_share * share);
        section.radius_outer_mm = {radius_mm, radius_mm};
        if (section.radius_inner_mm.from >= radius_mm || section.radius_inner_mm.to >= radius_mm) {
            fail(place, section.node,
                 "the lumen of section " + in_quotes(section.name) + " is wider than the table's radius");
        }
    }
}

Preset read_based_preset(const Place &place, const toml::table &table,
                         const std::map<std::string, Preset> &known)
{
    check_keys(place, table, {"description", "based_on", "table_5_1"});
    const toml::node &base_node = require(place, table, "based_on");
    const std::string base = to_text(place, base_node, "based_on");
    std::vector<std::string> names;
    for (const auto &[name, preset] : known) names.push_back(name);
    if (!known.contains(base))
        fail(place, &base_node, "there is no preset " + in_quotes(base) + suggestion(base, names));
    Preset preset = known.at(base);
    const toml::table &row = require_table(place, table, "table_5_1");
    preset.thesis = read_thesis_row(place.inside("table_5_1"), row);
    apply_thesis(place.inside("table_5_1"), *preset.thesis, preset.sections);
    return preset;
}

Preset read_preset(const Place &place, const toml::table &table, InstrumentKind kind,
                   const std::map<std::string, Preset> &known)
{
    Preset preset;
    if (table.contains("based_on")) {
        preset = read_based_preset(place, table, known);
    } else {
        check_keys(place, table, {"description", "lumen_friction", "all", "section", "based_on"});
        preset.lumen_friction = read_lumen_friction(place, table, kind);
        preset.sections = read_sections(place, table, kind);
    }
    preset.description = to_text(place, require(place, table, "description"), "description");
    return preset;
}

std::map<std::string, Preset> read_presets(const Place &place, const toml::table &root, InstrumentKind kind)
{
    const toml::table &table = require_table(place, root, "preset");
    std::map<std::string, Preset> presets;
    require_table(place.inside("preset"), table, default_preset);
    // Presets with sections of their own are read first, so that the other presets can be based on them
    // whatever the order in the file.
    for (const bool is_based : {false, true}) {
        for (const auto &[key, node] : table) {
            const std::string name(key.str());
            const Place inner = place.inside("preset " + in_quotes(name));
            const toml::table *one = node.as_table();
            if (!one) fail(inner, &node, "must be a table: [preset." + name + "]");
            if (one->contains("based_on") != is_based) continue;
            presets[name] = read_preset(inner, *one, kind, presets);
        }
    }
    return presets;
}

Instrument assemble(const Place &place, const Instrument &head, const std::string &name, const Preset &preset)
{
    Instrument instrument = head;
    instrument.preset = name;
    if (name != default_preset) instrument.name += " (" + name + ")";
    instrument.table.lumen_friction_milli =
        static_cast<std::uint32_t>(std::lround(preset.lumen_friction * 1e3));
    instrument.thesis = preset.thesis;
    add_profile(place.inside("preset " + in_quotes(name)), preset.sections, instrument);
    add_markers(instrument);
    return instrument;
}

} // namespace

double ThesisRow::bend_stiffness_N_m2() const
{
    return young_modulus * std::numbers::pi * std::pow(radius_m, 4) / 4.0;
}

std::pair<std::string, std::string> split_preset(const std::string &path)
{
    const std::string mark = ".toml:";
    const std::size_t at = path.rfind(mark);
    if (at == std::string::npos) return {path, ""};
    return {path.substr(0, at + mark.size() - 1), path.substr(at + mark.size())};
}

Instrument read_instrument(const std::string &path)
{
    const auto [file, asked] = split_preset(path);
    const toml::table root = parse(file, read_text_file(file));
    Sources sources;
    const Place place{file, sources, ""};
    const toml::node &format = require(place, root, "format");
    if (format.value<std::int64_t>() != 2) {
        fail(place, &format, "'format' must be 2; this file is of another version");
    }
    Instrument head;
    read_head(place, root, head);
    sources = read_sources(place, root);
    read_elements(place, root, head.table);
    head.shape = read_shape(place, root);
    head.side_holes = read_side_holes(place, root, head.kind);
    head.balloon = read_balloon(place, root, head.kind, head.table);
    const std::map<std::string, Preset> presets = read_presets(place, root, head.kind);
    std::string unused;
    if (const toml::node *node = sources.unused(unused))
        fail(place, node, "no value names the source " + in_quotes(unused));
    head.presets = {default_preset};
    for (const auto &[name, preset] : presets) {
        if (name != default_preset) head.presets.push_back(name);
    }
    std::optional<Instrument> wanted;
    for (const std::string &name : head.presets) {
        Instrument instrument = assemble(place, head, name, presets.at(name));
        if (name == (asked.empty() ? default_preset : asked)) wanted = std::move(instrument);
    }
    if (!wanted)
        throw FileError(file, 0, 0, "has no preset " + in_quotes(asked) + suggestion(asked, head.presets));
    return *wanted;
}

} // namespace crn
