// Reads and writes points as TOML.
#include "tools/centreline/fit/points.hpp"
#include "host/base/number_text.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/toml_reader.hpp"
#include "tools/centreline/formats.hpp"

namespace crn::centreline
{
namespace
{

Point point_of(const TomlTable &table)
{
    table.check_keys({"kind", "name", "after", "position_mm"});
    Point made;
    const std::string kind = table["kind"].one_of({"start", "end", "bifurcation"});
    made.kind = kind == "start" ? PointKind::start : kind == "end" ? PointKind::end : PointKind::bifurcation;
    if (table.has("name")) made.name = plain_name(table["name"].text());
    if (table.has("after")) made.after = plain_name(table["after"].text());
    made.position_mm = Eigen::Vector3d(table["position_mm"].three(1e5).data());
    return made;
}

} // namespace

const char *kind_name(PointKind kind)
{
    return kind == PointKind::start ? "start" : kind == PointKind::end ? "end" : "bifurcation";
}

PointText read_points(const std::filesystem::path &file)
{
    const TomlTable root =
        read_toml(file.string(), {"a text of points", "a text of points (docs/centreline.md has one)"});
    root.check_keys({"format", "mesh", "unit", "point"});
    root.check_format(1);
    PointText text;
    if (root.has("mesh")) text.mesh = root["mesh"].text();
    if (root.has("unit")) text.unit = root["unit"].one_of({"m", "cm", "mm", "um"});
    for (const TomlTable &table : root.tables("point")) {
        if (text.points.size() == points_max)
            table.fail("there are more than " + std::to_string(points_max) + " points: leave some out");
        text.points.push_back(point_of(table.inside("point " + std::to_string(text.points.size() + 1))));
    }
    return text;
}

std::string points_text(const PointText &text)
{
    std::string out = "# Points of a vessel tree, for `centreline fit` and `centreline edit`.\nformat = 1\n";
    const auto quoted = [](const std::string &plain) {
        std::string made = "\"";
        for (char c : plain) {
            if (c == '"' || c == '\\') made += '\\';
            if (static_cast<unsigned char>(c) >= 0x20) made += c;
        }
        return made + "\"";
    };
    if (!text.mesh.empty()) out += "mesh = " + quoted(text.mesh) + "\nunit = " + quoted(text.unit) + "\n";
    for (const Point &point : text.points) {
        out += "\n[[point]]\nkind = \"" + std::string(kind_name(point.kind)) + "\"\n";
        if (!point.name.empty()) out += "name = " + quoted(point.name) + "\n";
        if (!point.after.empty()) out += "after = " + quoted(point.after) + "\n";
        out += "position_mm = [" + trimmed_text(point.position_mm.x(), file_decimals) + ", " +
               trimmed_text(point.position_mm.y(), file_decimals) + ", " +
               trimmed_text(point.position_mm.z(), file_decimals) + "]\n";
    }
    return out;
}

void write_points(const std::filesystem::path &file, const PointText &text)
{
    write_whole_file(file.string(), points_text(text));
}

} // namespace crn::centreline
