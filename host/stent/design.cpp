#include "host/stent/design.hpp"
#include "host/model/instrument_toml.hpp"
#include "host/model/text.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace seld
{

namespace
{

using namespace instrument_file;

const std::vector<std::string> values = {
    "diameter_mm",      "diameter_max_mm",         "crimped_diameter_mm", "length_mm",
    "strut_length_mm",  "strut_width_mm",          "strut_thickness_mm",  "recoil_percent",
    "marker_length_mm", "ring_stiffness_N_per_mm", "retention_N"};
const std::vector<std::string> counts = {"rings", "crowns", "links"};
const std::vector<std::string> others = {"format",  "name",       "description",
                                         "sources", "connection", "material"};

int count_of(const Place &place, const toml::table &table, const std::string &key, int low, int high)
{
    const toml::node &node = require(place, table, key);
    const std::optional<std::int64_t> value = node.value_exact<std::int64_t>();
    if (!value) fail(place, &node, in_quotes(key) + " is not a whole number");
    check_bounds(place, node, key, static_cast<double>(*value), {double(low), double(high)});
    return static_cast<int>(*value);
}

toml::table parse(const std::string &path)
{
    try {
        return toml::parse(read_text_file(path), path);
    } catch (const toml::parse_error &error) {
        const toml::source_position at = error.source().begin;
        throw FileError(path, static_cast<int>(at.line), static_cast<int>(at.column),
                        std::string(error.description()));
    }
}

void read_sources(const Place &place, const toml::table &root)
{
    for (const auto &[key, node] : require_table(place, root, "sources")) {
        to_text(place, node, std::string(key.str()));
        place.sources.add(std::string(key.str()), node);
    }
}

void read_values(const Place &place, const toml::table &root, StentDesign &stent)
{
    const auto value = [&](const char *key, double low, double high) {
        return sourced_value(place, root, key, {low, high});
    };
    stent.diameter_mm = value("diameter_mm", 1.5, 14);
    stent.diameter_max_mm = value("diameter_max_mm", 1.5, 20);
    stent.crimped_diameter_mm = value("crimped_diameter_mm", 0.5, 4);
    stent.length_mm = value("length_mm", 4, 80);
    stent.strut_length_mm = value("strut_length_mm", 0.4, 6);
    stent.strut_width_mm = value("strut_width_mm", 0.03, 0.4);
    stent.strut_thickness_mm = value("strut_thickness_mm", 0.03, 0.4);
    stent.recoil = value("recoil_percent", 0, 20) / 100;
    stent.marker_length_mm = value("marker_length_mm", 0.3, 3);
    stent.ring_stiffness_N_per_mm = value("ring_stiffness_N_per_mm", 0.5, 100);
    stent.retention_N = value("retention_N", 0.05, 30);
}

// What every value by itself allows but all together do not.
void check_geometry(const Place &place, const toml::table &root, const StentDesign &stent)
{
    const auto at = [&](const char *key) { return root.get(key); };
    if (stent.links > stent.crowns)
        fail(place, at("links"),
             "'links' = " + number(stent.links) + " is more than the " + number(stent.crowns) +
                 " 'crowns' of a ring");
    if (stent.crimped_diameter_mm >= stent.diameter_mm)
        fail(place, at("crimped_diameter_mm"),
             "'crimped_diameter_mm' is not below 'diameter_mm' = " + number(stent.diameter_mm));
    if (stent.diameter_max_mm < stent.diameter_mm)
        fail(place, at("diameter_max_mm"),
             "'diameter_max_mm' is below 'diameter_mm' = " + number(stent.diameter_mm));
    const double widest = stent.chord_mm(stent.radius_on_mm(stent.diameter_max_mm / 2));
    if (stent.strut_length_mm < 1.05 * widest)
        fail(place, at("strut_length_mm"),
             "'strut_length_mm' = " + number(stent.strut_length_mm) +
                 " does not reach from crown to crown at 'diameter_max_mm': " + number(1.05 * widest) +
                 " at least, or more 'crowns'");
    const double least = stent.connection == StentConnection::facing ? 0.0 : stent.strut_width_mm;
    const double room = stent.connection == StentConnection::facing
                            ? stent.link_length_mm()
                            : stent.link_length_mm() - stent.ring_height_mm(stent.crimped_radius_mm());
    if (room < least)
        fail(place, at("rings"),
             "'rings' = " + number(stent.rings) + " of " +
                 number(stent.ring_height_mm(stent.crimped_radius_mm())) +
                 " mm do not fit into 'length_mm' = " + number(stent.length_mm) +
                 ": fewer, or shorter struts");
}

} // namespace

double StentDesign::chord_mm(double radius_mm) const
{
    return 2 * radius_mm * std::sin(std::numbers::pi / (2 * crowns));
}

double StentDesign::ring_height_mm(double radius_mm) const
{
    const double chord = chord_mm(radius_mm);
    return std::sqrt(std::max(strut_length_mm * strut_length_mm - chord * chord, 0.0));
}

double StentDesign::link_length_mm() const
{
    const double height = ring_height_mm(crimped_radius_mm());
    const double taken = connection == StentConnection::facing ? rings * height : height;
    return (length_mm - taken) / (rings - 1);
}

double StentDesign::length_at_mm(double radius_mm) const
{
    const double height = ring_height_mm(radius_mm);
    return (rings - 1) * link_length_mm() + (connection == StentConnection::facing ? rings * height : height);
}

StentDesign read_stent(const std::string &path)
{
    const toml::table root = parse(path);
    Sources sources;
    const Place place{path, sources, ""};
    std::vector<std::string> known = values;
    known.insert(known.end(), counts.begin(), counts.end());
    known.insert(known.end(), others.begin(), others.end());
    check_keys(place, root, known);
    if (count_of(place, root, "format", 1, 1000) != 1)
        fail(place, root.get("format"), "'format' is not 1, the only one that this program reads");
    read_sources(place, root);
    StentDesign stent;
    stent.name = to_text(place, require(place, root, "name"), "name");
    stent.description = to_text(place, require(place, root, "description"), "description");
    stent.material = to_text(place, require(place, root, "material"), "material");
    const toml::node &joined = require(place, root, "connection");
    const std::string connection = to_text(place, joined, "connection");
    if (connection != "offset" && connection != "facing")
        fail(place, &joined, "'connection' is " + in_quotes(connection) + ", neither 'offset' nor 'facing'");
    stent.connection = connection == "facing" ? StentConnection::facing : StentConnection::offset;
    stent.rings = count_of(place, root, "rings", 2, 60);
    stent.crowns = count_of(place, root, "crowns", 4, 24);
    stent.links = count_of(place, root, "links", 1, 24);
    read_values(place, root, stent);
    check_geometry(place, root, stent);
    std::string unused;
    if (const toml::node *node = sources.unused(unused))
        fail(place, node, "nothing names the source " + in_quotes(unused));
    return stent;
}

} // namespace seld
