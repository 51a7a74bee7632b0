// Reads a whole instrument file: its general data, the list of sources, and the presets. The code in this
// file also makes a preset from a table in the VCSim3 thesis.
#include "host/model/instrument.hpp"
#include "host/base/number_text.hpp"
#include "host/model/instrument_parts.hpp"
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace crn
{

namespace
{

using namespace instrument_file;

const std::string default_preset = "physical";

void read_head(const TomlTable &root, Instrument &instrument)
{
    root.check_keys({"format", "name", "kind", "description", "shape_name", "sources", "elements", "shape",
                     "side_holes", "whole", "balloon", "material", "preset"});
    instrument.name = root.words("name");
    instrument.description = root.words("description");
    instrument.shape_name = root.words("shape_name");
    const std::string kind = root["kind"].one_of({"wire", "catheter"});
    instrument.kind = kind == "wire" ? InstrumentKind::wire : InstrumentKind::catheter;
}

// Reads the length of the real tool, and the part of a monorail catheter that runs over a wire. The program
// uses the length of the real tool and of its monorail part only for the exchange of tools.
void read_whole(const TomlTable &root, InstrumentKind kind, crn_wire_instrument &wire)
{
    if (!root.has("whole")) return;
    const TomlTable table = root.table("whole").inside("whole");
    table.check_keys({"length_mm", "rail_mm", "source"});
    table.check_source();
    const double length_mm = table.number("length_mm", {100.0, 4000.0});
    wire.whole_um = static_cast<std::uint32_t>(std::lround(length_mm * 1e3));
    if (!table.has("rail_mm")) return;
    if (kind == InstrumentKind::wire)
        table["rail_mm"].fail("a wire has no lumen: 'rail_mm' is for catheters");
    wire.rail_um = static_cast<std::uint32_t>(std::lround(table.number("rail_mm", {10.0, length_mm}) * 1e3));
}

double read_lumen_friction(const TomlTable &table, InstrumentKind kind)
{
    if (kind == InstrumentKind::catheter) return table.sourced("lumen_friction", {0.0, 1.0});
    if (const TomlValue value = table["lumen_friction"])
        value.fail("a wire has no lumen: 'lumen_friction' is for catheters");
    return 0.0;
}

ThesisRow read_thesis_row(const TomlTable &table)
{
    table.check_keys({"row", "young_modulus_1e7", "radius_1e3", "density_1e5", "kp_1e3", "source"});
    table.check_source();
    constexpr NumberRange positive = {0.01, 1000.0};
    ThesisRow thesis;
    thesis.row = table.words("row");
    thesis.young_modulus = table.number("young_modulus_1e7", positive) * 1e7;
    thesis.radius_m = table.number("radius_1e3", {1.0, 20.0}) * 1e-4;
    thesis.density = table.number("density_1e5", positive) * 1e5;
    thesis.kp = table.number("kp_1e3", positive) * 1e3;
    return thesis;
}

TomlRange scaled(const TomlRange &range, double factor, NumberRange bounds)
{
    return {std::clamp(range.from * factor, bounds.low, bounds.high),
            std::clamp(range.to * factor, bounds.low, bounds.high)};
}

// See docs/instruments.md, "vcsim3-fit". The shaft of the preset from the thesis gets Young's modulus E and
// its radius from the thesis's table. The thesis's table does not describe the tip, so each value along the
// instrument keeps its ratio to the shaft's value from the base preset. The preset from the thesis also keeps
// the mass and the friction of the base preset.
void apply_thesis(const TomlTable &table, const ThesisRow &thesis, std::vector<Section> &sections)
{
    const double factor = thesis.bend_stiffness_N_m2() / sections.back().bend_N_m2.to;
    const double radius_mm = thesis.radius_m * 1e3;
    for (Section &section : sections) {
        section.bend_N_m2 = scaled(section.bend_N_m2, factor, stiffness_bounds);
        section.twist_N_m2 = scaled(section.twist_N_m2, factor, stiffness_bounds);
        // The metal core keeps its size, so the ratio of the core's radius to the new outer radius changes.
        const double share = section.radius_outer_mm.from / radius_mm;
        for (InstrumentLayer &layer : section.layers)
            layer.radius_share = std::min(1.0, layer.radius_share * share);
        section.radius_outer_mm = {radius_mm, radius_mm};
        if (section.radius_inner_mm.from >= radius_mm || section.radius_inner_mm.to >= radius_mm)
            section.table.in_place_of(table).fail("the lumen of section " + in_quotes(section.name) +
                                                  " is wider than the table's radius");
    }
}

Preset read_based_preset(const TomlTable &table, const std::map<std::string, Preset> &known)
{
    table.check_keys({"description", "based_on", "table_5_1"});
    const std::string base = table.words("based_on");
    std::vector<std::string> names;
    for (const auto &[name, preset] : known) names.push_back(name);
    if (!known.contains(base))
        table["based_on"].fail("there is no preset " + in_quotes(base) + suggestion(base, names));
    Preset preset = known.at(base);
    const TomlTable row = table.table("table_5_1").inside("table_5_1");
    preset.thesis = read_thesis_row(row);
    apply_thesis(row, *preset.thesis, preset.sections);
    return preset;
}

Preset read_preset(const TomlTable &table, InstrumentKind kind, const std::map<std::string, Preset> &known)
{
    Preset preset;
    if (table.has("based_on")) {
        preset = read_based_preset(table, known);
    } else {
        table.check_keys({"description", "lumen_friction", "all", "section", "based_on"});
        preset.lumen_friction = read_lumen_friction(table, kind);
        preset.sections = read_sections(table, kind);
    }
    preset.description = table.words("description");
    return preset;
}

std::map<std::string, Preset> read_presets(const TomlTable &root, InstrumentKind kind)
{
    const TomlTable table = root.table("preset");
    std::map<std::string, Preset> presets;
    table.inside("preset").table(default_preset);
    // Presets with sections of their own are read first, so that the other presets can be based on them
    // whatever the order in the file.
    for (const bool is_based : {false, true}) {
        for (const TomlValue &value : table.values()) {
            const std::string &name = value.key();
            if (!value.is_table())
                value.fail("preset " + in_quotes(name) + ": must be a table: [preset." + name + "]");
            const TomlTable one = value.table().inside("preset " + in_quotes(name));
            if (one.has("based_on") == is_based) presets[name] = read_preset(one, kind, presets);
        }
    }
    return presets;
}

Instrument assemble(const TomlTable &root, const Instrument &head, const std::string &name,
                    const Preset &preset)
{
    Instrument instrument = head;
    instrument.preset = name;
    if (name != default_preset) instrument.name += " (" + name + ")";
    instrument.table.lumen_friction_milli =
        static_cast<std::uint32_t>(std::lround(preset.lumen_friction * 1e3));
    instrument.thesis = preset.thesis;
    if (preset.thesis) forget_material(instrument.table); // the rod of the thesis is elastic
    add_profile(root.inside("preset " + in_quotes(name)), preset.sections, instrument);
    check_material(root, instrument.table);
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
    const TomlTable root = read_toml(file, {"an instrument", "an instrument's file (docs/instruments.md)"});
    root.check_format(2);
    Instrument head;
    read_head(root, head);
    root.read_sources();
    read_elements(root, head.table);
    head.shape = read_shape(root);
    head.side_holes = read_side_holes(root, head.kind);
    read_whole(root, head.kind, head.table);
    head.balloon = read_balloon(root, head.kind, head.table);
    read_material(root, head.kind, head.table);
    const std::map<std::string, Preset> presets = read_presets(root, head.kind);
    root.check_sources_used();
    head.presets = {default_preset};
    for (const auto &[name, preset] : presets) {
        if (name != default_preset) head.presets.push_back(name);
    }
    std::optional<Instrument> wanted;
    for (const std::string &name : head.presets) {
        Instrument instrument = assemble(root, head, name, presets.at(name));
        if (name == (asked.empty() ? default_preset : asked)) wanted = std::move(instrument);
    }
    if (!wanted) root.fail_file("has no preset " + in_quotes(asked) + suggestion(asked, head.presets));
    return *wanted;
}

std::string nesting_refusal(const Instrument &inside, const Instrument &outer)
{
    const auto millimetres = [](double um) { return number_text(um * 1e-3, 3) + " mm"; };
    std::uint32_t thickest_um = 0;
    for (std::uint16_t i = 0; i < inside.table.knots_count; i++)
        thickest_um = std::max(thickest_um, inside.table.knots[i].radius_outer_um);
    for (std::uint16_t i = 0; i < outer.table.knots_count; i++) {
        const crn_wire_knot &knot = outer.table.knots[i];
        if (knot.radius_inner_um >= thickest_um) continue;
        return "'" + inside.name + "' (" + millimetres(2.0 * thickest_um) + ") does not pass the lumen of '" +
               outer.name + "' (" + millimetres(2.0 * knot.radius_inner_um) + ", at " +
               millimetres(knot.arc_um) + " from its tip)";
    }
    return "";
}

} // namespace crn
