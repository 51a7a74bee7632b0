// Reads and writes points as TOML.
#include "tools/centreline/fit/points.hpp"
#include "host/base/pending_file.hpp"
#include "tools/bake/toml_file.hpp"
#include "tools/centreline/formats.hpp"

#include <cmath>
#include <set>

namespace crn::centreline
{
namespace
{

struct Reader {
    std::string file;

    [[noreturn]] void fail(const toml::node &node, const std::string &what) const
    {
        throw Fault(file + ":" + std::to_string(node.source().begin.line) + ": " + what);
    }

    void only(const toml::table &table, const std::set<std::string> &keys) const
    {
        for (const auto &[key, node] : table) {
            if (keys.count(std::string(key.str()))) continue;
            std::string list;
            for (const std::string &known : keys) list += (list.empty() ? "" : ", ") + known;
            fail(node, "there is no key '" + std::string(key.str()) + "' here: use one of " + list);
        }
    }

    std::string text(const toml::table &table, const char *key) const
    {
        const toml::node *node = table.get(key);
        if (!node) return "";
        if (!node->is_string()) fail(*node, std::string(key) + " must be a text in quotes");
        return node->value<std::string>().value();
    }

    Point point(const toml::table &table) const
    {
        only(table, {"kind", "name", "after", "position_mm"});
        Point made;
        const std::string kind = text(table, "kind");
        if (kind == "start")
            made.kind = PointKind::start;
        else if (kind == "bifurcation")
            made.kind = PointKind::bifurcation;
        else if (kind != "end")
            fail(table, "kind is '" + kind + "': use \"start\", \"end\" or \"bifurcation\"");
        made.name = plain_name(text(table, "name"));
        made.after = plain_name(text(table, "after"));
        const toml::node *position = table.get("position_mm");
        if (!position) fail(table, "the point needs position_mm = [x, y, z]");
        const toml::array *array = position->as_array();
        for (std::size_t k = 0; k < 3; ++k) {
            const auto value = array && array->size() == 3 ? array->get(k)->value<double>() : std::nullopt;
            if (!value || !std::isfinite(*value) || std::abs(*value) > 1e5)
                fail(*position, "position_mm must be three numbers within 100 m, like [1.0, 0.0, 0.0]");
            made.position_mm[static_cast<int>(k)] = *value;
        }
        return made;
    }
};

} // namespace

const char *kind_name(PointKind kind)
{
    return kind == PointKind::start ? "start" : kind == PointKind::end ? "end" : "bifurcation";
}

PointText read_points(const std::filesystem::path &file)
{
    const Reader reader{file.string()};
    const toml::table root =
        bake::read_toml(file, {4, "a text of points", "a text of points (docs/centreline.md has one)", ""});
    reader.only(root, {"format", "mesh", "unit", "point"});
    const toml::node *format = root.get("format");
    if (!format || format->value<std::int64_t>().value_or(0) != 1)
        throw Fault(file.string() + ": must begin with format = 1");
    PointText text;
    text.mesh = reader.text(root, "mesh");
    if (root.contains("unit")) text.unit = reader.text(root, "unit");
    if (millimetres_per(text.unit) == 0)
        reader.fail(*root.get("unit"), "unit is '" + text.unit + "': use m, cm, mm or um");
    const toml::node *points = root.get("point");
    if (!points) return text;
    if (!points->is_array_of_tables()) reader.fail(*points, "has [point]: write [[point]]");
    for (const toml::node &node : *points->as_array()) {
        if (text.points.size() == points_max)
            reader.fail(node,
                        "there are more than " + std::to_string(points_max) + " points: leave some out");
        text.points.push_back(reader.point(*node.as_table()));
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
        out += "position_mm = [" + number_text(point.position_mm.x()) + ", " +
               number_text(point.position_mm.y()) + ", " + number_text(point.position_mm.z()) + "]\n";
    }
    return out;
}

void write_points(const std::filesystem::path &file, const PointText &text)
{
    write_whole_file(file.string(), points_text(text));
}

} // namespace crn::centreline
