#include "host/report/instrument_list.hpp"
#include "host/base/examples.hpp"
#include "host/base/format.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/text.hpp"
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

namespace crn
{

namespace
{

namespace fs = std::filesystem;

std::string joined(const std::vector<std::string> &words)
{
    std::string text;
    for (const std::string &word : words) text += (text.empty() ? "" : ", ") + word;
    return text;
}

std::string shipped_folder()
{
    const std::vector<fs::path> folders = shipped_folders(instrument_files);
    if (folders.empty())
        throw std::runtime_error("no folder with instruments is found beside the program: run it in the "
                                 "repository, install it by make install, or name files or folders");
    return folders.front().string();
}

const char *kind_name(InstrumentKind kind)
{
    return kind == InstrumentKind::wire ? "wire" : "catheter";
}

std::string name_of(const ListedInstrument &item) // the word that a command line takes
{
    return fs::path(item.file).stem().string();
}

double outer_mm(const Instrument &instrument) // of the shaft
{
    return instrument.table.knots[instrument.table.knots_count - 1].radius_outer_um * 2e-3;
}

double inner_mm(const Instrument &instrument)
{
    return instrument.table.knots[instrument.table.knots_count - 1].radius_inner_um * 2e-3;
}

double at_tip(const Instrument &instrument, Stiffness which)
{
    return stiffness_at(instrument, which, 0.0);
}

double at_shaft(const Instrument &instrument, Stiffness which)
{
    return stiffness_at(instrument, which, instrument.length_m);
}

std::vector<std::string> toml_files(const std::string &folder)
{
    std::vector<std::string> files;
    std::error_code error;
    for (const auto &entry : fs::directory_iterator(folder, error)) {
        if (entry.path().extension() == ".toml") files.push_back(entry.path().string());
    }
    if (error) throw FileError(folder, 0, 0, "cannot list the folder: " + error.message());
    if (files.empty()) throw FileError(folder, 0, 0, "holds no .toml file");
    std::sort(files.begin(), files.end());
    return files;
}

ListedInstrument listed(const std::string &file, const Instrument &instrument)
{
    ListedInstrument item{file, instrument, {}};
    for (const std::string &name : instrument.presets) {
        if (name != instrument.preset) item.others.push_back(read_instrument(file + ":" + name));
    }
    return item;
}

void add_file(std::vector<ListedInstrument> &list, const std::string &path, const std::string &preset)
{
    const auto [file, named] = split_preset(path);
    const std::string wanted = named.empty() ? preset : named;
    list.push_back(listed(file, read_instrument(wanted.empty() ? file : file + ":" + wanted)));
}

void add_folder(std::vector<ListedInstrument> &list, const std::string &folder, const std::string &preset)
{
    for (const std::string &file : toml_files(folder)) {
        const Instrument instrument = read_instrument(file);
        const auto &names = instrument.presets;
        if (preset.empty() || std::find(names.begin(), names.end(), preset) != names.end()) {
            add_file(list, file, preset);
        }
    }
    if (list.empty()) throw FileError(folder, 0, 0, "no instrument in it has the preset '" + preset + "'");
}

nlohmann::ordered_json knots_json(const Instrument &instrument)
{
    nlohmann::ordered_json knots = nlohmann::ordered_json::array();
    for (std::uint16_t i = 0; i < instrument.table.knots_count; i++) {
        const crn_wire_knot &knot = instrument.table.knots[i];
        knots.push_back({{"arc_mm", knot.arc_um * 1e-3},
                         {"bend_stiffness_N_m2", knot.bend_stiffness_nN_m2 * 1e-9},
                         {"twist_stiffness_N_m2", knot.twist_stiffness_nN_m2 * 1e-9},
                         {"mass_kg_per_m", knot.mass_mg_per_m * 1e-6},
                         {"radius_outer_mm", knot.radius_outer_um * 1e-3},
                         {"radius_inner_mm", knot.radius_inner_um * 1e-3},
                         {"friction_kinetic", knot.friction_kinetic_milli * 1e-3},
                         {"friction_static", knot.friction_static_milli * 1e-3},
                         {"rest_curvature1_per_m", knot.rest_curvature1_per_m_milli * 1e-3},
                         {"rest_curvature2_per_m", knot.rest_curvature2_per_m_milli * 1e-3}});
    }
    return knots;
}

// Returns the law of a core that does not stay elastic (docs/instruments.md, "Materials").
nlohmann::ordered_json material_json(const crn_wire_instrument &table)
{
    nlohmann::ordered_json law = {
        {"kind", table.material_kind == CRN_WIRE_MATERIAL_SUPERELASTIC ? "superelastic" : "metal"},
        {"yield_strain", table.yield_strain_micro * 1e-6},
        {"young_modulus_GPa", table.core_modulus_MPa * 1e-3},
        {"hardening", table.hardening_milli * 1e-3}};
    if (table.material_kind == CRN_WIRE_MATERIAL_SUPERELASTIC) {
        law["unload"] = table.unload_milli * 1e-3;
        law["limit"] = table.limit_milli * 1e-3;
    }
    return law;
}

nlohmann::ordered_json one_json(const ListedInstrument &item)
{
    const Instrument &instrument = item.instrument;
    nlohmann::ordered_json one;
    one["file"] = item.file;
    one["name"] = instrument.name;
    one["kind"] = kind_name(instrument.kind);
    one["description"] = instrument.description;
    one["preset"] = instrument.preset;
    one["presets"] = instrument.presets;
    one["length_mm"] = instrument.length_m * 1e3;
    one["outer_diameter_mm"] = outer_mm(instrument);
    one["inner_diameter_mm"] = inner_mm(instrument);
    one["bend_stiffness_tip_N_m2"] = at_tip(instrument, Stiffness::bend);
    one["bend_stiffness_shaft_N_m2"] = at_shaft(instrument, Stiffness::bend);
    one["twist_stiffness_tip_N_m2"] = at_tip(instrument, Stiffness::twist);
    one["twist_stiffness_shaft_N_m2"] = at_shaft(instrument, Stiffness::twist);
    one["lumen_friction"] = instrument.table.lumen_friction_milli * 1e-3;
    if (instrument.table.material_kind != CRN_WIRE_MATERIAL_ELASTIC)
        one["material"] = material_json(instrument.table);
    one["nodes"] = line_node_count(instrument.table);
    one["shape"] = instrument.shape_name;
    one["shape_centreline_mm"] = nlohmann::ordered_json::array();
    for (const ShapePoint &point : unloaded_shape(instrument, 1e-3, 0.02)) {
        one["shape_centreline_mm"].push_back(
            {point.position_m.x() * 1e3, point.position_m.y() * 1e3, point.position_m.z() * 1e3});
    }
    if (instrument.thesis) {
        const ThesisRow &row = *instrument.thesis;
        one["table_5_1"] = {{"row", row.row},
                            {"young_modulus", row.young_modulus},
                            {"radius_m", row.radius_m},
                            {"density", row.density},
                            {"kp", row.kp},
                            {"bend_stiffness_N_m2", row.bend_stiffness_N_m2()}};
    }
    one["knots"] = knots_json(instrument);
    return one;
}

} // namespace

double stiffness_at(const Instrument &instrument, Stiffness which, double arc_m)
{
    const crn_wire_instrument &table = instrument.table;
    auto value = [&](int i) {
        const crn_wire_knot &knot = table.knots[i];
        return 1e-9 * (which == Stiffness::bend ? knot.bend_stiffness_nN_m2 : knot.twist_stiffness_nN_m2);
    };
    for (int i = 1; i < table.knots_count; i++) {
        const double from = table.knots[i - 1].arc_um, to = table.knots[i].arc_um;
        if (arc_m * 1e6 >= to || from == to) continue;
        return value(i - 1) + (arc_m * 1e6 - from) / (to - from) * (value(i) - value(i - 1));
    }
    return value(table.knots_count - 1);
}

std::vector<ListedInstrument> list_instruments(const std::vector<std::string> &paths,
                                               const std::string &preset)
{
    std::vector<ListedInstrument> list;
    for (const std::string &path : paths.empty() ? std::vector<std::string>{shipped_folder()} : paths) {
        std::error_code ignored;
        if (fs::is_directory(path, ignored)) {
            add_folder(list, path, preset);
        } else {
            add_file(list, path, preset);
        }
    }
    return list;
}

std::string instruments_text(const std::vector<ListedInstrument> &list)
{
    std::size_t width = 10, shape = 5, word = 4;
    for (const ListedInstrument &item : list) {
        word = std::max(word, name_of(item).size());
        width = std::max(width, item.instrument.name.size());
        shape = std::max(shape, item.instrument.shape_name.size());
    }
    const int name_width = static_cast<int>(width), shape_width = static_cast<int>(shape);
    const int word_width = static_cast<int>(word);
    std::string text = formatted("%-*s  %-*s  %-8s %9s %6s %6s %9s %9s  %-*s  %s\n", word_width, "name",
                                 name_width, "instrument", "kind", "length mm", "OD mm", "ID mm", "EI tip",
                                 "EI shaft", shape_width, "shape", "presets");
    for (const ListedInstrument &item : list) {
        const Instrument &one = item.instrument;
        const std::string inner = one.kind == InstrumentKind::wire ? "-" : formatted("%.2f", inner_mm(one));
        text += formatted("%-*s  ", word_width, name_of(item).c_str());
        text += formatted("%-*s  %-8s %9.0f %6.2f %6s %9.2e %9.2e  %-*s  ", name_width, one.name.c_str(),
                          kind_name(one.kind), one.length_m * 1e3, outer_mm(one), inner.c_str(),
                          at_tip(one, Stiffness::bend), at_shaft(one, Stiffness::bend), shape_width,
                          one.shape_name.c_str());
        text += joined(one.presets) + "\n";
    }
    return text + "EI in N m^2; OD, ID: outer and inner diameter of the shaft\n";
}

std::string instruments_json(const std::vector<ListedInstrument> &list)
{
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (const ListedInstrument &item : list) all.push_back(one_json(item));
    return all.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string instruments_markdown(const std::vector<ListedInstrument> &list)
{
    std::string text =
        "| file | instrument | length mm | OD / ID mm | EI tip | EI shaft | GJ shaft | friction tip, shaft "
        "| shape | EI shaft of `vcsim3-fit` |\n|---|---|---|---|---|---|---|---|---|---|\n";
    for (const ListedInstrument &item : list) {
        const Instrument &one = item.instrument;
        const crn_wire_knot &tip = one.table.knots[0], &hub = one.table.knots[one.table.knots_count - 1];
        const std::string inner = one.kind == InstrumentKind::wire ? "" : formatted(" / %.2f", inner_mm(one));
        std::string fit = "-";
        for (const Instrument &other : item.others) {
            if (other.thesis) fit = formatted("%.2e", at_shaft(other, Stiffness::bend));
        }
        text += formatted("| `%s` | %s | %.0f | %.2f%s ", name_of(item).c_str(), one.name.c_str(),
                          one.length_m * 1e3, outer_mm(one), inner.c_str());
        text += formatted("| %.2e | %.2e | %.2e | %.2f, %.2f | %s | %s |\n", at_tip(one, Stiffness::bend),
                          at_shaft(one, Stiffness::bend), at_shaft(one, Stiffness::twist),
                          tip.friction_kinetic_milli * 1e-3, hub.friction_kinetic_milli * 1e-3,
                          one.shape_name.c_str(), fit.c_str());
    }
    return text;
}

void write_instruments_table(const std::string &path, const std::vector<ListedInstrument> &list)
{
    std::string text = read_text_file(path);
    const std::size_t begin = text.find(table_begin), end = text.find(table_end);
    if (begin == std::string::npos || end == std::string::npos || end < begin) {
        throw FileError(path, 0, 0,
                        "lacks the two marks that enclose the table: " + table_begin + "... " + table_end);
    }
    const std::size_t inside = begin + table_begin.size();
    text.replace(inside, end - inside, instruments_markdown(list));
    write_whole_file(path, text);
}

} // namespace crn
