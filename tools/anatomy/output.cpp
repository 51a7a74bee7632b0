#include "tools/anatomy/output.hpp"
#include "host/base/number_text.hpp"
#include "host/base/pending_file.hpp"
#include "tools/anatomy/heart_sequence.hpp"
#include <algorithm>
#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace anatomy
{

namespace
{

static_assert(std::endian::native == std::endian::little,
              "PLY files are written by copying little-endian words");

template <typename T> void append(std::string &bytes, T value)
{
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes.append(raw, sizeof value);
}

std::string triple(const Vec3 &v)
{
    return "[" + crn::decimals_text(v.x(), 4) + ", " + crn::decimals_text(v.y(), 4) + ", " +
           crn::decimals_text(v.z(), 4) + "]";
}

nlohmann::ordered_json control_point(const CurvePoint &point, const std::string &vessel, size_t index)
{
    const Vec3 &p = point.position_mm;
    auto rounded = [](double value) { return std::round(value * 1e4) / 1e4; };
    return {{"id", std::to_string(index + 1)},
            {"label", vessel + "-" + std::to_string(index + 1)},
            {"description", ""},
            {"position", {rounded(p.x()), rounded(-p.z()), rounded(p.y())}},
            {"selected", true},
            {"locked", false},
            {"visibility", true},
            {"positionStatus", "defined"}};
}

// Returns the text of the scene's table [tree], which defines the vessels along which blood and contrast
// medium flow. The table [tree] names the files of the centrelines and gives the known flows of blood.
std::string tree_text(const VesselTree &tree, const std::string &small_vessels)
{
    std::string files, flows;
    for (const Vessel &vessel : tree.vessels) {
        files += (files.empty() ? "" : ", ") + ("\"" + file_stem(vessel.name) + ".mrk.json\"");
        if (vessel.flow_ml_min > 0)
            flows += (flows.empty() ? "" : ", ") + file_stem(vessel.name) + " = " +
                     crn::decimals_text(vessel.flow_ml_min, 4);
    }
    std::string left, right;
    for (const Vessel &artery : coronary_arteries(tree)) {
        std::string &names = artery.bed == Bed::right_coronary ? right : left;
        names += (names.empty() ? "\"" : ", \"") + file_stem(artery.name) + "\"";
    }
    std::string text = "\n# Where blood and contrast medium flow.\n[tree]\ncentrelines = [" + files + "]\n";
    text += "axes = [\"+x\", \"+z\", \"-y\"] # the files are LPS\n";
    text += "inlet = \"" + file_stem(tree.vessels.front().name) + "\"\n";
    if (!flows.empty()) text += "flow_ml_min = { " + flows + " }\n";
    if (!small_vessels.empty()) text += "small = \"" + small_vessels + "\" # picture and flow only\n";
    if (tree.coronary_count > 0) text += "left_coronary = [" + left + "]\nright_coronary = [" + right + "]\n";
    return text;
}

nlohmann::ordered_json markup_of(const NamedCurve &named)
{
    nlohmann::ordered_json points = nlohmann::ordered_json::array(), radii = nlohmann::ordered_json::array();
    for (size_t i = 0; i < named.curve.size(); i++) {
        points.push_back(control_point(named.curve[i], named.name, i));
        radii.push_back(std::round(named.curve[i].radius_mm * 1e4) / 1e4);
    }
    const nlohmann::ordered_json radius = {
        {"name", "Radius"}, {"enabled", true}, {"units", "mm"}, {"controlPointValues", radii}};
    return {{"type", "Curve"},
            {"coordinateSystem", "LPS"},
            {"coordinateUnits", "mm"},
            {"locked", false},
            {"labelFormat", "%N-%d"},
            {"controlPoints", points},
            {"measurements", nlohmann::ordered_json::array({radius})}};
}

} // namespace

std::string file_stem(const std::string &name)
{
    std::string stem = name;
    std::replace(stem.begin(), stem.end(), ' ', '_');
    return stem;
}

void write_ply(const std::filesystem::path &file, const Mesh &mesh, const std::string &comment)
{
    std::string bytes = "ply\nformat binary_little_endian 1.0\ncomment " + comment + "\nelement vertex " +
                        std::to_string(mesh.vertices_mm.size()) +
                        "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                        std::to_string(mesh.triangles.size()) +
                        "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const Vec3 &vertex : mesh.vertices_mm)
        for (int axis = 0; axis < 3; axis++) append(bytes, static_cast<float>(vertex[axis]));
    for (const auto &triangle : mesh.triangles) {
        append(bytes, static_cast<uint8_t>(3));
        for (uint32_t vertex : triangle) append(bytes, static_cast<int32_t>(vertex));
    }
    crn::write_whole_file(file.string(), bytes);
}

void write_centreline(const std::filesystem::path &file, const Vessel &vessel)
{
    constexpr double STEP_MM = 4.0;
    write_centrelines(file, {{vessel.name, vessel_curve(vessel, STEP_MM)}});
}

void write_centrelines(const std::filesystem::path &file, const std::vector<NamedCurve> &curves)
{
    nlohmann::ordered_json markups = nlohmann::ordered_json::array();
    for (const NamedCurve &curve : curves) markups.push_back(markup_of(curve));
    const nlohmann::ordered_json document = {
        {"@schema",
         "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/"
         "Schema/markups-schema-v1.0.3.json#"},
        {"markups", markups}};
    crn::write_whole_file(file.string(), document.dump(1) + "\n");
}

void write_scene(const std::filesystem::path &file, const VesselTree &tree, const std::vector<Body> &bodies,
                 const std::string &lesions, const std::string &small_vessels)
{
    std::string text =
        "# Written by `anatomy " + tree.made_by + "`. Patient frame: +x patient left, +y head, +z front.\n";
    text += "[scene]\nname = \"" + tree.title + "\"\n";
    text += tree.file.empty()
                ? "source = \"Cournand's own model from stated dimensions; see docs/anatomy.md\"\n\n"
                : "source = \"vessels of a user's file (`anatomy list` shows their sources); see "
                  "docs/vessels.md\"\n\n";
    text += "[lumen]\nmesh = \"lumen.ply\"\nunit = \"mm\"\n";
    if (tree.coronary_count > 0) text += "level_max = 2 # small arteries\ntolerance_mm = 0.12\n";
    text += "\n";
    text += "# Mouth of the inserter sheath and the direction in which a wire leaves it.\n";
    text += "[entry]\nposition_mm = " + triple(tree.entry_position_mm) +
            "\ndirection = " + triple(tree.entry_direction) + "\n";
    text += tree_text(tree, small_vessels);
    text += lesions;
    if (tree.coronary_count > 0)
        text += "\n# How it beats, and how breath carries it (docs/heart.md).\n[motion]\n"
                "frames = \"lumen_beat\"\n"
                "inhaled = \"lumen_beat_inhaled.ply\"\n"
                "end_systole = 11\n";
    for (const Body &body : bodies) {
        text += "\n[[body]]\nname = \"" + body.name + "\"\nmesh = \"" + file_stem(body.name) +
                ".ply\"\nunit = \"mm\"\n";
        text += "material = \"" + body.material + "\"\n";
        if (tree.coronary_count > 0 && moves_with_heart(body.name)) text += "moves = true\n";
        if (body.is_breathing) text += "inhaled = \"" + file_stem(body.name) + "_inhaled.ply\"\n";
        if (!body.inside.empty()) text += "inside = \"" + body.inside + "\"\n";
    }
    crn::write_whole_file(file.string(), text);
}

} // namespace anatomy
