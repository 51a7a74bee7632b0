// Reads the balloon of an instrument file (docs/balloon.md, docs/instruments.md).
#include "host/model/instrument_parts.hpp"
#include <cmath>

namespace crn::instrument_file
{

namespace
{

constexpr double mm = 1e-3, um_per_mm = 1e3, kPa_per_bar = 100.0;

// Reads the rows of [[balloon.at]]: { pressure_bar, diameter_mm }. Both values must increase from row to row.
void read_rows(const TomlTable &table, crn_wire_instrument &wire)
{
    const std::vector<TomlTable> rows = table.tables("at");
    if (rows.size() < 2 || rows.size() > CRN_WIRE_MAX_instrument_balloon)
        table.fail("the table of pressures and diameters has " + std::to_string(rows.size()) +
                   " rows: write 2 to 12 [[balloon.at]]");
    for (const TomlTable &row : rows) {
        row.check_keys({"pressure_bar", "diameter_mm"});
        const double bar = row.number("pressure_bar", {1.0, 39.0}),
                     diameter_mm = row.number("diameter_mm", {0.5, 20.0});
        const crn_wire_balloon_point point = {
            static_cast<std::uint32_t>(std::lround(bar * kPa_per_bar)),
            static_cast<std::uint32_t>(std::lround(diameter_mm * um_per_mm))};
        if (wire.balloon_count > 0) {
            const crn_wire_balloon_point &last = wire.balloon[wire.balloon_count - 1];
            if (point.pressure_kPa <= last.pressure_kPa)
                row["pressure_bar"].fail_key("must rise from row to row");
            if (point.diameter_um <= last.diameter_um)
                row["diameter_mm"].fail_key("must rise from row to row");
        }
        wire.balloon[wire.balloon_count++] = point;
    }
}

} // namespace

std::optional<BalloonLabel> read_balloon(const TomlTable &root, InstrumentKind kind,
                                         crn_wire_instrument &wire)
{
    const TomlValue balloon = root["balloon"];
    if (!balloon) return {};
    if (kind != InstrumentKind::catheter) balloon.fail("a wire has no balloon: 'balloon' is for catheters");
    const TomlTable table = balloon.table().inside("balloon");
    table.check_keys({"from_mm", "to_mm", "nominal_bar", "rated_burst_bar", "burst_bar",
                      "crossing_profile_mm", "markers_mm", "source", "at"});
    table.check_source();
    const double from_mm = table.number("from_mm", {0.5, 200.0}),
                 to_mm = table.number("to_mm", {from_mm + 2.0, from_mm + 60.0});
    wire.balloon_count = 0;
    read_rows(table, wire);
    const double last_bar = wire.balloon[wire.balloon_count - 1].pressure_kPa / kPa_per_bar;
    BalloonLabel label;
    label.nominal_kPa = kPa_per_bar * table.number("nominal_bar", {1.0, last_bar});
    label.rated_burst_kPa = kPa_per_bar * table.number("rated_burst_bar", {1.0, 40.0});
    label.crossing_profile_m = mm * table.number("crossing_profile_mm", {0.3, 6.0});
    const double burst_bar =
        table.number("burst_bar", {std::max(last_bar + 0.01, label.rated_burst_kPa / kPa_per_bar), 40.0});
    wire.balloon_distal_um = static_cast<std::uint32_t>(std::lround(from_mm * um_per_mm));
    wire.balloon_proximal_um = static_cast<std::uint32_t>(std::lround(to_mm * um_per_mm));
    wire.balloon_burst_kPa = static_cast<std::uint32_t>(std::lround(burst_bar * kPa_per_bar));
    const TomlValue markers = table["markers_mm"];
    if (!markers.is_list() || markers.list().empty() || markers.list().size() > 4)
        markers.fail_key("must be a list of 1 to 4 places of marker bands");
    for (const TomlValue &marker : markers.list())
        label.marker_arcs_m.push_back(marker.number({from_mm, to_mm}) * mm);
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
