#include "tools/lab/case/case.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/toml.hpp"
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>

namespace crn::insertion
{

namespace
{

// Holds one table of the file and its place for error messages.
struct Reading {
    std::string file, place; // place: "" or "depth 2: "
    const toml::table &table;

    [[noreturn]] void refuse(const std::string &key, const std::string &what) const
    {
        const toml::node *node = table.get(key);
        const unsigned line = node ? node->source().begin.line : table.source().begin.line;
        throw CaseError(file + ":" + std::to_string(line) + ": " + place + key + ": " + what);
    }

    double number(const std::string &key, double low, double high) const
    {
        const std::optional<double> value = table[key].value<double>();
        char range[80];
        std::snprintf(range, sizeof range, "give a number from %g to %g", low, high);
        if (!value)
            refuse(key, table.contains(key) ? std::string("is no number: ") + range
                                            : std::string("is missing: ") + range);
        if (!(*value >= low && *value <= high)) refuse(key, std::string("is out of range: ") + range);
        return *value;
    }

    std::string text(const std::string &key, bool wanted) const
    {
        if (!table.contains(key) && !wanted) return {};
        const std::optional<std::string> value = table[key].value<std::string>();
        if (!value)
            refuse(key, table.contains(key) ? "is no text: put it in quotes" : "is missing: give a text");
        if (value->empty()) refuse(key, "is empty: give a text");
        return *value;
    }

    Eigen::Vector3d vector(const std::string &key) const
    {
        const toml::array *array = table[key].as_array();
        Eigen::Vector3d result;
        if (!array || array->size() != 3) refuse(key, "give three numbers: [x, y, z]");
        for (unsigned i = 0; i < 3; ++i) {
            const std::optional<double> value = array->get(i)->value<double>();
            if (!value || !(std::abs(*value) <= 1e4)) refuse(key, "give three numbers from -10000 to 10000");
            result[i] = *value;
        }
        return result;
    }

    void only(const std::set<std::string> &keys) const
    {
        for (const auto &[key, node] : table)
            if (!keys.contains(std::string(key.str())))
                refuse(std::string(key.str()), "is no key of a case: remove it or mend its name");
    }
};

toml::table parse(const std::filesystem::path &file)
{
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored))
        throw CaseError(file.string() + ": no such file: give a case's folder (docs/ct.md)");
    if (std::filesystem::file_size(file, ignored) > 1u << 20)
        throw CaseError(file.string() + ": over 1 MiB, so hardly a case");
    try {
        std::ostringstream text;
        text << std::ifstream(file, std::ios::binary).rdbuf();
        return parse_toml(text.str(), file.string());
    } catch (const TomlError &error) {
        throw CaseError(file.string() + (error.line > 0 ? ":" + std::to_string(error.line) : "") + ": " +
                        error.what());
    }
}

std::vector<Depth> read_depths(const Reading &root)
{
    const toml::array *array = root.table["depth"].as_array();
    if (!array || array->empty() || array->size() > 16) root.refuse("depth", "give 1 to 16 tables [[depth]]");
    std::vector<Depth> depths;
    for (const toml::node &node : *array) {
        const std::string place = "depth " + std::to_string(depths.size() + 1) + ": ";
        if (!node.is_table()) root.refuse("depth", "give tables [[depth]]");
        const Reading reading{root.file, place, *node.as_table()};
        reading.only({"name", "inserted_mm", "turn_deg", "scan", "centreline"});
        Depth depth;
        depth.name = reading.text("name", true);
        depth.inserted_mm = reading.number("inserted_mm", 1e-3, 1000);
        depth.turn_deg = reading.number("turn_deg", -3600, 3600);
        depth.scan = reading.text("scan", false);
        depth.centreline = reading.text("centreline", true);
        if (!depths.empty() && depth.inserted_mm <= depths.back().inserted_mm)
            reading.refuse("inserted_mm", "is not more than at the depth before: put the depths in order");
        depths.push_back(depth);
    }
    return depths;
}

// Reads lines of numbers under a header that names at least the first `columns` of them.
std::vector<std::vector<double>> read_columns(const std::filesystem::path &file, const std::string &header,
                                              std::size_t columns)
{
    std::ifstream stream(file);
    if (!stream) throw CaseError(file.string() + ": cannot be read: is it there?");
    std::string line;
    if (!std::getline(stream, line) || line.compare(0, header.size(), header) != 0)
        throw CaseError(file.string() + ":1: does not begin with " + header);
    std::vector<std::vector<double>> rows;
    for (std::size_t number = 2; std::getline(stream, line); ++number) {
        if (line.find_first_not_of(" \r\t") == std::string::npos) continue;
        if (rows.size() == 100000) throw CaseError(file.string() + ": over 100000 lines");
        std::vector<double> row;
        const char *at = line.c_str();
        for (std::size_t i = 0; i < columns; ++i) {
            char *end = nullptr;
            const double value = std::strtod(at, &end);
            if (end == at || !std::isfinite(value) || std::abs(value) > 1e6 ||
                (i + 1 < columns && *end != ','))
                throw CaseError(file.string() + ":" + std::to_string(number) + ": give " +
                                std::to_string(columns) + " numbers with commas between them");
            row.push_back(value);
            at = end + (*end == ',');
        }
        rows.push_back(row);
    }
    return rows;
}

std::string toml_quoted(const std::filesystem::path &path)
{
    std::string text = "\"";
    for (const char c : path.string()) {
        if (c == '"' || c == '\\') text += '\\';
        text += c;
    }
    return text + '"';
}

} // namespace

std::string number_text(double value)
{
    char text[40];
    std::snprintf(text, sizeof text, "%.9g", value);
    return text;
}

std::filesystem::path Case::path_in(const std::filesystem::path &path) const
{
    return path.empty() || path.is_absolute() ? path : folder / path;
}

double Case::turn_deg_at(double inserted_mm) const
{
    if (inserted_mm <= depths.front().inserted_mm) return depths.front().turn_deg;
    for (std::size_t i = 1; i < depths.size(); ++i)
        if (inserted_mm <= depths[i].inserted_mm) {
            const Depth &from = depths[i - 1], &to = depths[i];
            const double share = (inserted_mm - from.inserted_mm) / (to.inserted_mm - from.inserted_mm);
            return from.turn_deg + share * (to.turn_deg - from.turn_deg);
        }
    return depths.back().turn_deg;
}

Case read_case(const std::filesystem::path &folder_or_file, CaseParts wanted)
{
    std::error_code ignored;
    const std::filesystem::path file = std::filesystem::is_directory(folder_or_file, ignored)
                                           ? folder_or_file / "case.toml"
                                           : folder_or_file;
    const toml::table table = parse(file);
    const bool wants_all = wanted == CaseParts::all;
    const Reading root{file.string(), "", table};
    root.only({"format", "name", "instrument", "scene", "surface", "mouth_mm", "direction", "gravity_m_s2",
               "friction_kinetic", "friction_static", "speed_mm_per_s", "force", "depth"});
    if (root.number("format", 1, 1e6) != 1)
        root.refuse("format", "is not 1, the only one this program knows");
    Case c;
    c.folder = file.parent_path();
    c.name = root.text("name", true);
    c.instrument = root.text("instrument", true);
    if (wants_all)
        for (const char *key : {"scene", "mouth_mm", "direction"})
            if (!table.contains(key))
                root.refuse(key, "is missing: give it, or let ct segment find it in the case's scans");
    c.scene = root.text("scene", false);
    c.surface = root.text("surface", false);
    c.force = root.text("force", false);
    c.has_mouth = table.contains("mouth_mm") || table.contains("direction");
    if (c.has_mouth) {
        c.mouth_mm = root.vector("mouth_mm");
        c.direction = root.vector("direction");
        if (std::abs(c.direction.norm() - 1) > 1e-3) root.refuse("direction", "is not of length 1");
        c.direction.normalize();
    }
    if (table.contains("gravity_m_s2")) c.gravity_m_s2 = root.vector("gravity_m_s2");
    if (c.gravity_m_s2.norm() > 20.0) root.refuse("gravity_m_s2", "is more than 20 m/s^2");
    c.friction_kinetic = root.number("friction_kinetic", 0, 1);
    c.friction_static = root.number("friction_static", c.friction_kinetic, 1);
    c.speed_mm_per_s = root.number("speed_mm_per_s", 1, 200);
    c.depths = read_depths(root);
    return c;
}

// Returns three numbers as TOML, with the end of the line.
static std::string vector_text(const Eigen::Vector3d &v)
{
    return "[" + number_text(v.x()) + ", " + number_text(v.y()) + ", " + number_text(v.z()) + "]\n";
}

void complete_case(const Case &c)
{
    const std::filesystem::path file = c.folder / "case.toml";
    const toml::table table = parse(file);
    std::string added; // the lines to add
    const auto add = [&](const std::string &key, const std::string &value) {
        if (!table.contains(key)) added += key + " = " + value;
    };
    if (!c.surface.empty()) add("surface", toml_quoted(c.surface) + "\n");
    if (!c.scene.empty()) add("scene", toml_quoted(c.scene) + "\n");
    if (c.has_mouth) {
        add("mouth_mm", vector_text(c.mouth_mm));
        add("direction", vector_text(c.direction));
    }
    if (added.empty()) return;
    std::ifstream stream(file, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(stream), {}};
    // The lines are inserted after the line of `format`, which is a key of the first table.
    const toml::node *format = table.get("format");
    std::size_t at = 0;
    for (unsigned line = 0; format && line < format->source().begin.line; ++line)
        at = std::min(text.find('\n', at), text.size() - 1) + 1;
    write_whole_file(file.string(), text.insert(at, added));
}

void write_case(const Case &c)
{
    std::string text = "format = 1\nname = " + toml_quoted(c.name) +
                       "\ninstrument = " + toml_quoted(c.instrument) + "\nscene = " + toml_quoted(c.scene) +
                       "\n";
    if (!c.surface.empty()) text += "surface = " + toml_quoted(c.surface) + "\n";
    if (!c.force.empty()) text += "force = " + toml_quoted(c.force) + "\n";
    text += "mouth_mm = " + vector_text(c.mouth_mm) + "direction = " + vector_text(c.direction);
    if (c.gravity_m_s2 != Eigen::Vector3d::Zero()) text += "gravity_m_s2 = " + vector_text(c.gravity_m_s2);
    text += "friction_kinetic = " + number_text(c.friction_kinetic) +
            "\nfriction_static = " + number_text(c.friction_static) +
            "\nspeed_mm_per_s = " + number_text(c.speed_mm_per_s) + "\n";
    for (const Depth &depth : c.depths) {
        text += "\n[[depth]]\nname = " + toml_quoted(depth.name) +
                "\ninserted_mm = " + number_text(depth.inserted_mm) +
                "\nturn_deg = " + number_text(depth.turn_deg) + "\n";
        if (!depth.scan.empty()) text += "scan = " + toml_quoted(depth.scan) + "\n";
        text += "centreline = " + toml_quoted(depth.centreline) + "\n";
    }
    write_whole_file((c.folder / "case.toml").string(), text);
}

std::vector<Eigen::Vector3d> read_centreline(const std::filesystem::path &file)
{
    std::vector<Eigen::Vector3d> points;
    for (const std::vector<double> &row : read_columns(file, "x_mm,y_mm,z_mm", 3))
        points.emplace_back(row[0], row[1], row[2]);
    if (points.size() < 2) throw CaseError(file.string() + ": fewer than two points, so no line");
    return points;
}

void write_centreline(const std::filesystem::path &file, const std::vector<Eigen::Vector3d> &points_mm)
{
    std::string text = "x_mm,y_mm,z_mm\n";
    for (const Eigen::Vector3d &point : points_mm)
        text += number_text(point.x()) + "," + number_text(point.y()) + "," + number_text(point.z()) + "\n";
    write_whole_file(file.string(), text);
}

std::vector<ForceSample> read_force(const std::filesystem::path &file)
{
    std::vector<ForceSample> samples;
    for (const std::vector<double> &row : read_columns(file, "inserted_mm,axial_mN", 2)) {
        if (!samples.empty() && row[0] < samples.back().inserted_mm)
            throw CaseError(file.string() + ": the insertion falls at sample " +
                            std::to_string(samples.size() + 1) + ": give the trace of an insertion");
        samples.push_back({row[0], row[1]});
    }
    if (samples.size() < 2) throw CaseError(file.string() + ": fewer than two samples, so no trace");
    return samples;
}

void write_force(const std::filesystem::path &file, const std::vector<ForceSample> &samples)
{
    std::string text = "inserted_mm,axial_mN\n";
    for (const ForceSample &sample : samples)
        text += number_text(sample.inserted_mm) + "," + number_text(sample.axial_mN) + "\n";
    write_whole_file(file.string(), text);
}

} // namespace crn::insertion
