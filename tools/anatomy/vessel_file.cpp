#include "tools/anatomy/vessel_file.hpp"
#include "host/base/examples.hpp"
#include "host/base/number_text.hpp"
#include "host/base/terminal.hpp"
#include "host/base/toml_reader.hpp"
#include "tools/anatomy/heart_course.hpp"
#include "tools/anatomy/organs.hpp"
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

namespace anatomy
{

namespace
{

using crn::NumberRange;
using crn::TomlTable;
using crn::TomlValue;

constexpr int FORMAT = 1;
constexpr size_t STATIONS_MAX = 200, FILES_MAX = 8, NAME_BYTES_MAX = 40, VESSEL_NAME_BYTES_MAX = 31,
                 TITLE_BYTES_MAX = 80, TEXT_BYTES_MAX = 300;
constexpr double POSITION_MAX_MM = 1000.0, APART_MIN_MM = 0.5, LENGTH_MAX_MM = 3000.0, TURN_MAX_DEG = 90.0;
constexpr NumberRange Y_MM = {-POSITION_MAX_MM, POSITION_MAX_MM}, DIAMETER_MM = {1, 60},
                      CORONARY_DIAMETER_MM = {1, 10}, SMALL_DIAMETER_MM = {0.1, 60},
                      FLOW_ML_MIN = {0.1, 10000}, WINDING = {1, 1.5}, FILLET_MM = {0, 10},
                      CORONARY_FILLET_MM = {0, 3}, HEIGHT = {0, 1.2}, ANGLE_DEG = {-360, 360},
                      FROM_END_MM = {0, LENGTH_MAX_MM};

/* Holds the content of a vessel file, and states whether the file's positions are in the patient's frame. */
struct File {
    TomlTable root;
    bool is_in_patient = true;
};

/* Returns the text of a key; the text must have one line and only printable characters. */
std::string line_of(const TomlValue &value, size_t bytes_max)
{
    value.words();
    const std::string text = value.text(bytes_max);
    if (crn::printable(text) != text) value.fail_key("has a character that cannot be printed");
    return text;
}

/* Returns the name of a vessel from the file; this name becomes part of file names and a key of the scene's
 * text. */
std::string vessel_name(const TomlValue &value)
{
    const std::string name = line_of(value, VESSEL_NAME_BYTES_MAX);
    const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
    const auto is_allowed = [&](char c) {
        return is_letter(c) || (c >= '0' && c <= '9') || c == ' ' || c == '-' || c == '_';
    };
    if (!is_letter(name[0]) || !std::all_of(name.begin(), name.end(), is_allowed))
        value.fail_key("must begin with a letter and have only letters of English, digits, spaces, - and _");
    return name;
}

/* Returns the title. The scene's text puts the title in quotes, so the title itself must not contain
 * quotes. */
std::string title_of(const TomlValue &value)
{
    const std::string title = line_of(value, TITLE_BYTES_MAX);
    if (title.find_first_of("\"\\") != std::string::npos)
        value.fail_key("must have no quotes and no backslashes");
    return title;
}

Vec3 position_of(const File &file, const TomlValue &value)
{
    static const Solid raised = skin(), beside = skin({.arms = Arms::beside});
    const std::array<double, 3> xyz = value.three(POSITION_MAX_MM);
    const Vec3 position(xyz[0], xyz[1], xyz[2]);
    if (file.is_in_patient && std::min(raised.distance(position), beside.distance(position)) > 0.0)
        value.fail_key("is outside of the patient's skin: the frame is in mm, +x patient left, +y head, "
                       "+z front, with its origin between T12 and L1");
    return position;
}

// --- stations ---

/* Holds one point of a vessel's course as the vessel file gives it. A point of a coronary artery is given
 * either by a position, or by a height and an angle on the heart. */
struct GivenStation {
    TomlTable table;
    Station station; // diameter 0: not given
    bool is_on_heart = false;
    double height = 0, angle_deg = 0;
};

/* Returns the text of `source`, with "@key" replaced by its text in [sources]. */
std::string source_of(const File &file, const TomlTable &table)
{
    table.check_source();
    const std::string text = line_of(table["source"], TEXT_BYTES_MAX);
    if (text[0] != '@') return text;
    const size_t colon = std::min(text.find(':'), text.size());
    return file.root.table("sources").words(text.substr(1, colon - 1)) + text.substr(colon);
}

void read_heart_place(GivenStation &given)
{
    given.is_on_heart = true;
    given.height = given.table.number("height", HEIGHT);
    given.angle_deg = given.table.number("angle_deg", ANGLE_DEG);
    const std::optional<Vec3> there = on_heart(given.height, given.angle_deg);
    if (!there) given.table.fail("the axis of the left ventricle is outside of the heart at this 'height'");
    given.station.position_mm = *there;
}

GivenStation read_station(const File &file, const TomlTable &table, bool is_coronary, bool is_lumen)
{
    std::vector<std::string> known = {"position_mm", "diameter_mm", "name", "source"};
    if (is_coronary) known.insert(known.begin() + 1, {"height", "angle_deg"});
    table.check_keys(known);
    GivenStation given{table, {Vec3::Zero(), 0.0, "", ""}};
    const bool has_place = table.has("position_mm");
    if (!has_place && is_coronary && !table.has("height"))
        table.fail("needs 'position_mm', or 'height' and 'angle_deg'");
    if (has_place && (table.has("height") || table.has("angle_deg")))
        table.fail("has both 'position_mm' and 'height' or 'angle_deg'");
    if (is_coronary && !has_place)
        read_heart_place(given);
    else
        given.station.position_mm = position_of(file, table["position_mm"]);
    if (!given.is_on_heart || table.has("diameter_mm"))
        given.station.diameter_mm = table.number("diameter_mm", !is_lumen     ? SMALL_DIAMETER_MM
                                                                : is_coronary ? CORONARY_DIAMETER_MM
                                                                              : DIAMETER_MM);
    if (!table.has("name")) {
        if (table.has("source"))
            table["source"].fail("'source' without 'name': name the station, so that it is listed");
        return given;
    }
    given.station.name = line_of(table["name"], NAME_BYTES_MAX);
    given.station.source = source_of(file, table);
    return given;
}

void check_neighbours(const GivenStation &before, const GivenStation &here)
{
    const double apart_mm = (here.station.position_mm - before.station.position_mm).norm();
    if (apart_mm < APART_MIN_MM)
        here.table.fail("is " + crn::number_text(apart_mm) + " mm from the station before it, less than " +
                        crn::number_text(APART_MIN_MM));
    if (before.is_on_heart && !here.is_on_heart)
        here.table.fail("has a position behind a station on the heart: positions come first");
    const double turn_deg = std::abs(here.angle_deg - before.angle_deg);
    if (before.is_on_heart && turn_deg > TURN_MAX_DEG)
        here.table.fail("'angle_deg' turns by " + crn::number_text(turn_deg) + " degrees, more than " +
                        crn::number_text(TURN_MAX_DEG) + ": add stations, or write -10 in place of 350");
}

std::vector<GivenStation> read_stations(const File &file, const TomlTable &vessel, bool is_coronary,
                                        bool is_lumen)
{
    const TomlValue value = vessel["stations"];
    if (value && !value.is_list())
        value.fail_key("must be a list: [{ position_mm = [...], diameter_mm = ... }, ...]");
    const std::vector<TomlValue> list = value.list();
    if (list.size() < 2 || list.size() > STATIONS_MAX)
        value.fail("has " + std::to_string(list.size()) + " stations: give 2 to " +
                   std::to_string(STATIONS_MAX));
    std::vector<GivenStation> stations;
    double length_mm = 0;
    for (const TomlValue &one : list) {
        const std::string where = "station " + std::to_string(stations.size() + 1);
        if (!one.is_table()) one.fail(where + ": must be { position_mm = [x, y, z], diameter_mm = ... }");
        stations.push_back(read_station(file, one.table().inside(where), is_coronary, is_lumen));
        if (stations.size() < 2) continue;
        const GivenStation &before = stations[stations.size() - 2], &here = stations.back();
        check_neighbours(before, here);
        length_mm += (here.station.position_mm - before.station.position_mm).norm();
    }
    if (length_mm > LENGTH_MAX_MM)
        value.fail("is " + crn::number_text(length_mm) + " mm long, more than " +
                   crn::number_text(LENGTH_MAX_MM));
    return stations;
}

/* Returns all points that define a vessel's course. Points that are given on the heart become a curve on the
 * heart's surface. */
std::vector<Station> course_of(const TomlTable &vessel, const std::vector<GivenStation> &given)
{
    std::vector<Station> stations;
    std::vector<HeartMark> marks;
    for (const GivenStation &one : given) {
        const Station &station = one.station;
        if (one.is_on_heart)
            marks.push_back({one.height, one.angle_deg, station.diameter_mm, station.name, station.source});
        else
            stations.push_back(station);
    }
    if (marks.empty()) return stations;
    const TomlValue value = vessel["stations"];
    if (marks.size() < 2) value.fail("has one station on the heart: give two or more, or none");
    if (marks.front().diameter_mm <= 0 || marks.back().diameter_mm <= 0)
        value.fail("the first and the last station on the heart need 'diameter_mm'");
    try {
        for (Station &station : heart_course(marks)) stations.push_back(std::move(station));
    } catch (const std::domain_error &error) {
        value.fail(error.what());
    }
    return stations;
}

// --- vessels ---

Bed tissue_of(const TomlTable &table, bool is_lumen)
{
    if (is_lumen) table["tissue"].fail_key("belongs to a vessel with lumen = false");
    const std::string tissue = table["tissue"].one_of({"kidney", "gut", "other"});
    return tissue == "kidney" ? Bed::kidney : tissue == "gut" ? Bed::gut : Bed::body;
}

GivenVessel read_vessel(const File &file, const TomlValue &value, bool is_coronary)
{
    const std::string kind = is_coronary ? "[[coronary]]" : "[[vessel]]";
    if (!value.is_table()) value.fail_key("must be written as " + kind);
    GivenVessel given;
    given.is_coronary = is_coronary;
    given.place = {file.root.file(), value.line()};
    Vessel &vessel = given.vessel;
    vessel.name = vessel_name(value.table().inside(kind)["name"]);
    const TomlTable table = value.table().inside("vessel '" + vessel.name + "'");
    std::vector<std::string> known = {"name", "parent", "replaces", "flow_ml_min", "stations"};
    known.push_back(is_coronary ? "side" : "tissue");
    known.push_back("lumen");
    known.push_back("winding");
    known.push_back("joins");
    table.check_keys(known);
    vessel.is_lumen = !table.has("lumen") || table["lumen"].truth();
    if (table.has("winding")) {
        if (vessel.is_lumen) table["winding"].fail_key("belongs to a vessel with lumen = false");
        vessel.winding = table.number("winding", WINDING);
    }
    if (table.has("tissue")) vessel.bed = tissue_of(table, vessel.is_lumen);
    if (table.has("parent")) vessel.parent = table.words("parent");
    given.replaces = table.has("replaces") && table["replaces"].truth();
    given.has_side = table.has("side");
    if (given.has_side)
        vessel.bed =
            table["side"].one_of({"left", "right"}) == "left" ? Bed::left_coronary : Bed::right_coronary;
    if (table.has("joins")) {
        if (vessel.is_lumen) table["joins"].fail_key("belongs to a vessel with lumen = false");
        if (!table.has("flow_ml_min")) table["joins"].fail_key("needs the flow that passes: 'flow_ml_min'");
        vessel.joins = table.words("joins");
    }
    if (table.has("flow_ml_min")) vessel.flow_ml_min = table.sourced("flow_ml_min", FLOW_ML_MIN);
    vessel.stations = course_of(table, read_stations(file, table, is_coronary, vessel.is_lumen));
    return given;
}

GivenEntry read_entry(const TomlTable &root)
{
    const TomlValue value = root["entry"];
    const TomlTable table = value.table().inside("entry");
    table.check_keys({"vessel", "y_mm", "from_end_mm"});
    GivenEntry entry;
    entry.place = {root.file(), value.line()};
    entry.vessel = table.words("vessel");
    if (table.has("y_mm") == table.has("from_end_mm")) table.fail("needs either 'y_mm' or 'from_end_mm'");
    if (table.has("y_mm"))
        entry.y_mm = table.number("y_mm", Y_MM);
    else
        entry.from_end_mm = table.number("from_end_mm", FROM_END_MM);
    return entry;
}

// --- files ---

/* Returns the path of the vessel file that this vessel file extends. A path such as "shipped:aorta.toml"
 * names a shipped file; any other path is relative to this vessel file. */
std::string extended_file(const TomlTable &root)
{
    const std::string text = line_of(root["extends"], TEXT_BYTES_MAX), shipped = "shipped:";
    if (!text.starts_with(shipped)) {
        const std::filesystem::path path = std::filesystem::path(root.file()).parent_path() / text;
        if (!std::filesystem::is_regular_file(path))
            root["extends"].fail_key("names " + path.string() + ", but there is no such file");
        return path.string();
    }
    const std::string name = text.substr(shipped.size());
    if (name.find('/') != std::string::npos)
        root["extends"].fail_key("has a path behind 'shipped:', where only a name belongs");
    try {
        return shipped_vessel_file(name);
    } catch (const std::runtime_error &error) {
        root["extends"].fail(error.what());
    }
}

TreeDraft read_draft(const std::string &path, size_t depth);

/* Reads all keys of this vessel file except its vessels, and also reads the vessel file that it extends. */
TreeDraft read_head(const TomlTable &root, size_t depth)
{
    root.check_keys({"format", "title", "extends", "frame", "fillet_mm", "coronary_fillet_mm", "sources",
                     "entry", "vessel", "coronary"});
    root.check_format(FORMAT);
    const bool is_extending = root.has("extends");
    TreeDraft draft;
    if (is_extending) {
        if (depth >= FILES_MAX)
            root["extends"].fail("over " + std::to_string(FILES_MAX) +
                                 " files extend each other: is there a circle?");
        draft = read_draft(extended_file(root), depth + 1);
        if (root.has("frame")) root["frame"].fail("'frame' is that of the file in 'extends'");
    } else {
        draft.is_in_patient = root["frame"].one_of({"patient", "phantom"}) == "patient";
    }
    draft.title = title_of(root["title"]);
    if (root.has("fillet_mm") || !is_extending) draft.fillet_mm = root.number("fillet_mm", FILLET_MM);
    if (root.has("coronary_fillet_mm"))
        draft.coronary_fillet_mm = root.number("coronary_fillet_mm", CORONARY_FILLET_MM);
    if (root.has("entry") || !is_extending) draft.entry = read_entry(root);
    return draft;
}

void check_source_texts(const TomlTable &root)
{
    if (!root.has("sources")) return;
    for (const TomlValue &value : root.table("sources").inside("sources").values())
        line_of(value, TEXT_BYTES_MAX);
}

TreeDraft read_draft(const std::string &path, size_t depth)
{
    const TomlTable root = crn::read_toml(path, {"a file of vessels", "a file of vessels"});
    root.read_sources();
    check_source_texts(root);
    TreeDraft draft = read_head(root, depth);
    const File file = {root, draft.is_in_patient};
    for (const char *kind : {"vessel", "coronary"}) {
        const bool is_coronary = std::string_view(kind) == "coronary";
        if (!root.has(kind)) continue;
        if (!root[kind].is_list()) root[kind].fail_key("must be written as [[" + std::string(kind) + "]]");
        if (is_coronary && !draft.is_in_patient) root[kind].fail("[[coronary]] needs frame = \"patient\"");
        for (const TomlValue &one : root[kind].list()) add_vessel(draft, read_vessel(file, one, is_coronary));
    }
    root.check_sources_used();
    return draft;
}

} // namespace

TreeDraft read_vessel_draft(const std::string &file)
{
    return read_draft(file, 1);
}

VesselTree read_vessels(const std::string &file)
{
    VesselTree tree = tree_of(read_vessel_draft(file), file);
    tree.file = file;
    return tree;
}

std::string shipped_vessel_file(const std::string &name)
{
    const crn::FileSearch search = crn::search_file(crn::shipped_folders(crn::anatomy_files), name);
    if (!search.path.empty()) return search.path;
    const std::string text = "there is no file " + name + " in shared/examples/anatomies";
    if (!search.others.empty()) throw std::runtime_error(text + crn::suggestion(name, search.others));
    throw std::runtime_error(text +
                             ", nor in share/cournand/examples/anatomies where it is installed: run the "
                             "program in the repository, or install it by make install");
}

VesselTree shipped_vessels(const std::string &name)
{
    VesselTree tree = read_vessels(shipped_vessel_file(name + ".toml"));
    tree.file.clear();
    tree.made_by = name;
    return tree;
}

} // namespace anatomy
