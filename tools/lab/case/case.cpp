#include "tools/lab/case/case.hpp"
#include "host/base/number_text.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/toml_reader.hpp"
#include <cmath>
#include <cstdlib>
#include <fstream>

namespace crn::insertion
{

namespace
{

Eigen::Vector3d vector_of(const TomlTable &table, const char *key)
{
    return Eigen::Vector3d(table[key].three(1e4).data());
}

TomlTable parse(const std::filesystem::path &file)
{
    return read_toml(file.string(), {"a case", "a case's folder (docs/ct.md)"});
}

std::filesystem::path path_of(const TomlTable &table, const char *key)
{
    return table.has(key) ? table.words(key) : "";
}

std::vector<Depth> read_depths(const TomlTable &root)
{
    const std::vector<TomlTable> tables = root["depth"].tables();
    if (tables.empty() || tables.size() > 16) root["depth"].fail_key("must be 1 to 16 tables [[depth]]");
    std::vector<Depth> depths;
    for (const TomlTable &one : tables) {
        const TomlTable table = one.inside("depth " + std::to_string(depths.size() + 1));
        table.check_keys({"name", "inserted_mm", "turn_deg", "scan", "centreline"});
        Depth depth;
        depth.name = table.words("name");
        depth.inserted_mm = table.number("inserted_mm", {1e-3, 1000});
        depth.turn_deg = table.number("turn_deg", {-3600, 3600});
        depth.scan = path_of(table, "scan");
        depth.centreline = table.words("centreline");
        if (!depths.empty() && depth.inserted_mm <= depths.back().inserted_mm)
            table["inserted_mm"].fail_key("is not more than at the depth before: put the depths in order");
        depths.push_back(depth);
    }
    return depths;
}

// Reads `columns` numbers from every line of a CSV file; the file's first line must begin with `header`.
std::vector<std::vector<double>> read_columns(const std::filesystem::path &file, const std::string &header,
                                              std::size_t columns)
{
    std::ifstream stream(file);
    if (!stream) throw Fault(file.string() + ": cannot be read: is it there?");
    std::string line;
    if (!std::getline(stream, line) || line.compare(0, header.size(), header) != 0)
        throw Fault(file.string() + ":1: does not begin with " + header);
    std::vector<std::vector<double>> rows;
    for (std::size_t number = 2; std::getline(stream, line); ++number) {
        if (line.find_first_not_of(" \r\t") == std::string::npos) continue;
        if (rows.size() == 100000) throw Fault(file.string() + ": over 100000 lines");
        std::vector<double> row;
        const char *at = line.c_str();
        for (std::size_t i = 0; i < columns; ++i) {
            char *end = nullptr;
            const double value = std::strtod(at, &end);
            if (end == at || !std::isfinite(value) || std::abs(value) > 1e6 ||
                (i + 1 < columns && *end != ','))
                throw Fault(file.string() + ":" + std::to_string(number) + ": give " +
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
    const TomlTable root = parse(file);
    root.check_keys({"format", "name", "instrument", "scene", "surface", "mouth_mm", "direction",
                     "gravity_m_s2", "friction_kinetic", "friction_static", "speed_mm_per_s", "force",
                     "depth"});
    root.check_format(1);
    Case c;
    c.folder = file.parent_path();
    c.name = root.words("name");
    c.instrument = root.words("instrument");
    if (wanted == CaseParts::all)
        for (const char *key : {"scene", "mouth_mm", "direction"})
            if (!root.has(key))
                root[key].fail_key("is missing: give it, or let ct segment find it in the case's scans");
    c.scene = path_of(root, "scene");
    c.surface = path_of(root, "surface");
    c.force = path_of(root, "force");
    c.has_mouth = root.has("mouth_mm") || root.has("direction");
    if (c.has_mouth) {
        c.mouth_mm = vector_of(root, "mouth_mm");
        c.direction = vector_of(root, "direction");
        if (std::abs(c.direction.norm() - 1) > 1e-3) root["direction"].fail_key("is not of length 1");
        c.direction.normalize();
    }
    if (root.has("gravity_m_s2")) c.gravity_m_s2 = vector_of(root, "gravity_m_s2");
    if (c.gravity_m_s2.norm() > 20.0) root["gravity_m_s2"].fail_key("is more than 20 m/s^2");
    c.friction_kinetic = root.number("friction_kinetic", {0, 1});
    c.friction_static = root.number("friction_static", {c.friction_kinetic, 1});
    c.speed_mm_per_s = root.number("speed_mm_per_s", {1, 200});
    c.depths = read_depths(root);
    return c;
}

// Returns three numbers as a TOML array, with an end of line.
static std::string vector_text(const Eigen::Vector3d &v)
{
    return "[" + number_text(v.x(), file_digits) + ", " + number_text(v.y(), file_digits) + ", " +
           number_text(v.z(), file_digits) + "]\n";
}

void complete_case(const Case &c)
{
    const std::filesystem::path file = c.folder / "case.toml";
    const TomlTable root = parse(file);
    std::string added; // the lines to add
    const auto add = [&](const std::string &key, const std::string &value) {
        if (!root.has(key)) added += key + " = " + value;
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
    // The function inserts the new lines directly after the line with the key `format`, because this line
    // belongs to the first table of the TOML file.
    std::size_t at = 0;
    for (int line = 0; line < root["format"].line(); ++line)
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
    text += "friction_kinetic = " + number_text(c.friction_kinetic, file_digits) +
            "\nfriction_static = " + number_text(c.friction_static, file_digits) +
            "\nspeed_mm_per_s = " + number_text(c.speed_mm_per_s, file_digits) + "\n";
    for (const Depth &depth : c.depths) {
        text += "\n[[depth]]\nname = " + toml_quoted(depth.name) +
                "\ninserted_mm = " + number_text(depth.inserted_mm, file_digits) +
                "\nturn_deg = " + number_text(depth.turn_deg, file_digits) + "\n";
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
    if (points.size() < 2) throw Fault(file.string() + ": fewer than two points, so no line");
    return points;
}

void write_centreline(const std::filesystem::path &file, const std::vector<Eigen::Vector3d> &points_mm)
{
    std::string text = "x_mm,y_mm,z_mm\n";
    for (const Eigen::Vector3d &point : points_mm)
        text += number_text(point.x(), file_digits) + "," + number_text(point.y(), file_digits) + "," +
                number_text(point.z(), file_digits) + "\n";
    write_whole_file(file.string(), text);
}

std::vector<ForceSample> read_force(const std::filesystem::path &file)
{
    std::vector<ForceSample> samples;
    for (const std::vector<double> &row : read_columns(file, "inserted_mm,axial_mN", 2)) {
        if (!samples.empty() && row[0] < samples.back().inserted_mm)
            throw Fault(file.string() + ": the insertion falls at sample " +
                        std::to_string(samples.size() + 1) + ": give the trace of an insertion");
        samples.push_back({row[0], row[1]});
    }
    if (samples.size() < 2) throw Fault(file.string() + ": fewer than two samples, so no trace");
    return samples;
}

void write_force(const std::filesystem::path &file, const std::vector<ForceSample> &samples)
{
    std::string text = "inserted_mm,axial_mN\n";
    for (const ForceSample &sample : samples)
        text += number_text(sample.inserted_mm, file_digits) + "," +
                number_text(sample.axial_mN, file_digits) + "\n";
    write_whole_file(file.string(), text);
}

} // namespace crn::insertion
