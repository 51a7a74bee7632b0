// Reads the balloon of an instrument file (docs/balloon.md, docs/instruments.md).
#include "host/model/instrument_parts.hpp"
#include <cmath>

namespace crn::instrument_file
{

namespace
{

constexpr double mm = 1e-3, um_per_mm = 1e3, kPa_per_bar = 100.0;

// Reads the rows of [[balloon.at]]: { pressure_bar, diameter_mm }. Both values must increase from row to row.
void read_rows(const Place &place, const toml::table &table, crn_wire_instrument &wire)
{
    const auto rows = tables_of(place, table, "at");
    if (rows.size() < 2 || rows.size() > CRN_WIRE_MAX_instrument_balloon)
        fail(place, &table,
             "the table of pressures and diameters has " + std::to_string(rows.size()) +
                 " rows: write 2 to 12 [[balloon.at]]");
    for (const toml::table *row : rows) {
        check_keys(place, *row, {"pressure_bar", "diameter_mm"});
        const toml::node &pressure = require(place, *row, "pressure_bar"),
                         &diameter = require(place, *row, "diameter_mm");
        const double bar = to_number(place, pressure, "pressure_bar"),
                     diameter_mm = to_number(place, diameter, "diameter_mm");
        check_bounds(place, pressure, "pressure_bar", bar, {1.0, 39.0});
        check_bounds(place, diameter, "diameter_mm", diameter_mm, {0.5, 20.0});
        const crn_wire_balloon_point point = {
            static_cast<std::uint32_t>(std::lround(bar * kPa_per_bar)),
            static_cast<std::uint32_t>(std::lround(diameter_mm * um_per_mm))};
        if (wire.balloon_count > 0) {
            const crn_wire_balloon_point &last = wire.balloon[wire.balloon_count - 1];
            if (point.pressure_kPa <= last.pressure_kPa)
                fail(place, &pressure, "'pressure_bar' must rise from row to row");
            if (point.diameter_um <= last.diameter_um)
                fail(place, &diameter, "'diameter_mm' must rise from row to row");
        }
        wire.balloon[wire.balloon_count++] = point;
    }
}

double one(const Place &place, const toml::table &table, const char *key, Bounds bounds)
{
    const toml::node &node = require(place, table, key);
    const double value = to_number(place, node, key);
    check_bounds(place, node, key, value, bounds);
    return value;
}

} // namespace

std::optional<BalloonLabel> read_balloon(const Place &place, const toml::table &root, InstrumentKind kind,
                                         crn_wire_instrument &wire)
{
    const toml::node *node = root.get("balloon");
    if (!node) return {};
    if (kind != InstrumentKind::catheter)
        fail(place, node, "a wire has no balloon: 'balloon' is for catheters");
    const toml::table &table = require_table(place, root, "balloon");
    const Place inner = place.inside("balloon");
    check_keys(inner, table,
               {"from_mm", "to_mm", "nominal_bar", "rated_burst_bar", "burst_bar", "crossing_profile_mm",
                "markers_mm", "source", "at"});
    check_source(inner, table);
    const double from_mm = one(inner, table, "from_mm", {0.5, 200.0}),
                 to_mm = one(inner, table, "to_mm", {from_mm + 2.0, from_mm + 60.0});
    wire.balloon_count = 0;
    read_rows(inner, table, wire);
    const double last_bar = wire.balloon[wire.balloon_count - 1].pressure_kPa / kPa_per_bar;
    BalloonLabel label;
    label.nominal_kPa = kPa_per_bar * one(inner, table, "nominal_bar", {1.0, last_bar});
    label.rated_burst_kPa = kPa_per_bar * one(inner, table, "rated_burst_bar", {1.0, 40.0});
    label.crossing_profile_m = mm * one(inner, table, "crossing_profile_mm", {0.3, 6.0});
    const double burst_bar = one(inner, table, "burst_bar",
                                 {std::max(last_bar + 0.01, label.rated_burst_kPa / kPa_per_bar), 40.0});
    wire.balloon_distal_um = static_cast<std::uint32_t>(std::lround(from_mm * um_per_mm));
    wire.balloon_proximal_um = static_cast<std::uint32_t>(std::lround(to_mm * um_per_mm));
    wire.balloon_burst_kPa = static_cast<std::uint32_t>(std::lround(burst_bar * kPa_per_bar));
    const toml::node &markers = require(inner, table, "markers_mm");
    const toml::array *list = markers.as_array();
    if (!list || list->empty() || list->size() > 4)
        fail(inner, &markers, "'markers_mm' must be a list of 1 to 4 places of marker bands");
    for (const toml::node &marker : *list) {
        const double at_mm = to_number(inner, marker, "markers_mm");
        check_bounds(inner, marker, "markers_mm", at_mm, {from_mm, to_mm});
        label.marker_arcs_m.push_back(at_mm * mm);
    }
    return label;
}

void add_markers(Instrument &instrument)
{
    if (!instrument.balloon) return;
    // a platinum sleeve of 1 mm, about 30 um thick, on the inner shaft, whose radius is half of the folded
    // balloon's
    constexpr double half_m = 0.5 * mm, share = 0.5, fill = 0.25;
    for (const double arc_m : instrument.balloon->marker_arcs_m)
        instrument.layers.push_back({arc_m - half_m, arc_m + half_m, "platinum", fill, share});
}

} // namespace crn::instrument_file
