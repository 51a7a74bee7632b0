// Draws the picture of `cournand instruments`: one row per instrument, with the same axes in every row.
#include "host/base/format.hpp"
#include "host/picture/canvas.hpp"
#include "host/report/instrument_list.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{

namespace
{

constexpr Ink black = {25, 28, 38}, grey = {105, 110, 122}, faint = {228, 230, 235}, line = {180, 184, 192};
constexpr Ink bend_ink = {20, 90, 180}, twist_ink = {225, 125, 20}, fit_ink = {150, 150, 155};
constexpr Ink wire_ink = {70, 76, 90}, catheter_ink = {40, 120, 130}, lumen_ink = {205, 232, 232};
constexpr Ink band = {247, 248, 250};

constexpr int head_px = 104, foot_px = 52, row_px = 178, gap_px = 8; // heights
struct Column {
    int left, right;
};
constexpr Column text_column = {20, 452}, profile_column = {530, 1130}, tip_column = {1160, 1340},
                 shape_column = {1370, 1990};
constexpr int sheet_px = 2010;

constexpr double profile_mm = 400.0; // of the x axis, from the tip
constexpr double decade_low = -7.0, decade_high = -2.0;
constexpr double tip_px_per_mm = 10.0, shape_px_per_mm = 3.0;

struct Row {
    int top, bottom; // of the plots
};

Row row_at(std::size_t index)
{
    const int top = head_px + static_cast<int>(index) * row_px;
    return {top + gap_px, top + row_px - gap_px};
}

void centred(Sheet &sheet, double x, int y, const std::string &text, int scale, Ink ink)
{
    sheet.text(static_cast<int>(std::lround(x)) - Sheet::text_width(text, scale) / 2, y, text, scale, ink);
}

// --- figures
// -----------------------------------------------------------------------------------------------------

void draw_figures(Sheet &sheet, const ListedInstrument &item, const Row &row)
{
    const Instrument &one = item.instrument;
    const crn_wire_knot &hub = one.table.knots[one.table.knots_count - 1];
    std::string size =
        formatted("%.0f mm, ", one.length_m * 1e3) + formatted("OD %.2f", hub.radius_outer_um * 2e-3);
    size +=
        one.kind == InstrumentKind::wire
            ? " mm"
            : formatted(", ID %.2f mm", one.table.knots[one.table.knots_count - 1].radius_inner_um * 2e-3);
    std::string presets;
    for (const std::string &name : one.presets) presets += (presets.empty() ? "" : ", ") + name;
    const std::string stiffness =
        formatted("EI %.2e", stiffness_at(one, Stiffness::bend, 0.0)) +
        formatted(" to %.2e N m^2", stiffness_at(one, Stiffness::bend, one.length_m));
    const std::string lines[] = {(one.kind == InstrumentKind::wire ? "wire, " : "catheter, ") +
                                     one.shape_name,
                                 size, stiffness, presets};
    int y = row.top + 10;
    sheet.text(text_column.left, y, one.name, 2, black);
    y += 32;
    for (const std::string &text : lines) {
        sheet.text(text_column.left, y, text, 2, grey);
        y += 26;
    }
}

// --- stiffness
// ---------------------------------------------------------------------------------------------------

double profile_x(double arc_mm)
{
    return profile_column.left + (profile_column.right - profile_column.left) * arc_mm / profile_mm;
}

double profile_y(const Row &row, double stiffness_N_m2)
{
    const double share = (std::log10(stiffness_N_m2) - decade_low) / (decade_high - decade_low);
    return row.bottom - (row.bottom - row.top) * share;
}

void draw_profile_axes(Sheet &sheet, const Row &row)
{
    for (int mm = 0; mm <= static_cast<int>(profile_mm); mm += 50) {
        const int x = static_cast<int>(std::lround(profile_x(mm)));
        sheet.box(x, row.top, x + 1, row.bottom, mm % 100 == 0 ? line : faint);
    }
    for (int decade = -7; decade <= -2; decade++) {
        const int y = static_cast<int>(std::lround(profile_y(row, std::pow(10.0, decade))));
        sheet.box(profile_column.left, y, profile_column.right + 1, y + 1, faint);
        if (decade == -7 || decade == -2) continue; // these labels would be too near to the neighbouring rows
        const std::string label = "1e" + std::to_string(decade);
        sheet.text(profile_column.left - 12 - Sheet::text_width(label, 2), y - 7, label, 2, grey);
    }
}

std::vector<SheetPoint> profile_line(const Instrument &instrument, Stiffness which, const Row &row)
{
    std::vector<SheetPoint> points;
    for (double x = profile_column.left; x <= profile_column.right; x += 1.0) {
        const double arc_mm =
            (x - profile_column.left) * profile_mm / (profile_column.right - profile_column.left);
        points.push_back({x, profile_y(row, stiffness_at(instrument, which, arc_mm * 1e-3))});
    }
    return points;
}

void draw_profile(Sheet &sheet, const ListedInstrument &item, const Row &row)
{
    draw_profile_axes(sheet, row);
    sheet.clip(profile_column.left, row.top, profile_column.right + 1, row.bottom + 1);
    for (const Instrument &other : item.others) {
        sheet.stroke(profile_line(other, Stiffness::bend, row), 2.5, fit_ink, 8.0);
    }
    sheet.stroke(profile_line(item.instrument, Stiffness::twist, row), 2.5, twist_ink);
    sheet.stroke(profile_line(item.instrument, Stiffness::bend, row), 3.0, bend_ink);
    sheet.unclip();
}

// --- shape
// -------------------------------------------------------------------------------------------------------

void draw_grid(Sheet &sheet, const Column &column, const Row &row, double px_per_mm, double step_mm)
{
    for (double x = column.left; x <= column.right + 0.5; x += step_mm * px_per_mm) {
        sheet.box(static_cast<int>(x), row.top, static_cast<int>(x) + 1, row.bottom, faint);
    }
    for (double y = row.top; y <= row.bottom + 0.5; y += step_mm * px_per_mm) {
        sheet.box(column.left, static_cast<int>(y), column.right, static_cast<int>(y) + 1, faint);
    }
}

// Describes the box around the distal part of an instrument's shape, in mm, with a border of half the
// instrument's width.
struct Bounds {
    double x_min = 1e9, x_max = -1e9, y_min = 1e9, y_max = -1e9;
};

Bounds bounds_of(const std::vector<ShapePoint> &shape, double from_tip_mm, double radius_mm)
{
    Bounds bounds;
    for (const ShapePoint &point : shape) {
        if (point.arc_m * 1e3 > from_tip_mm) break;
        bounds.x_min = std::min(bounds.x_min, point.position_m.x() * 1e3 - radius_mm);
        bounds.x_max = std::max(bounds.x_max, point.position_m.x() * 1e3 + radius_mm);
        bounds.y_min = std::min(bounds.y_min, point.position_m.y() * 1e3 - radius_mm);
        bounds.y_max = std::max(bounds.y_max, point.position_m.y() * 1e3 + radius_mm);
    }
    return bounds;
}

// Returns the bounding box of the part of the shape that one drawing shows: the whole shape, or the longest
// distal part that fits.
Bounds fitting(const std::vector<ShapePoint> &shape, double wide_mm, double high_mm, double radius_mm)
{
    double length_mm = shape.back().arc_m * 1e3;
    for (;; length_mm *= 0.9) {
        const Bounds bounds = bounds_of(shape, length_mm, radius_mm);
        const bool fits = bounds.x_max - bounds.x_min < wide_mm && bounds.y_max - bounds.y_min < high_mm;
        if (fits || length_mm < 1.0) return bounds;
    }
}

// Draws the shape of the instrument as seen along the axis d2, with the forward direction to the right and
// the axis d1 upwards. The foremost point of the shape is near the right edge of the drawing, and the shape
// is centred vertically.
void draw_shape(Sheet &sheet, const Instrument &instrument, const Column &column, const Row &row,
                double px_per_mm)
{
    constexpr double margin_px = 6.0;
    const double wide_mm = (column.right - column.left - 2.0 * margin_px) / px_per_mm;
    const double high_mm = (row.bottom - row.top - 2.0 * margin_px) / px_per_mm;
    const double radius_mm = instrument.table.knots[0].radius_outer_um * 1e-3;
    const std::vector<ShapePoint> shape = unloaded_shape(instrument, 0.5e-3, 2e-3 * wide_mm);
    const Bounds bounds = fitting(shape, wide_mm, high_mm, radius_mm);
    const double middle_px = 0.5 * (row.top + row.bottom), middle_mm = 0.5 * (bounds.y_min + bounds.y_max);
    std::vector<SheetPoint> points;
    for (const ShapePoint &point : shape) {
        points.push_back({column.right - margin_px - (bounds.x_max - point.position_m.x() * 1e3) * px_per_mm,
                          middle_px - (point.position_m.y() * 1e3 - middle_mm) * px_per_mm});
    }
    sheet.clip(column.left, row.top, column.right, row.bottom);
    const bool is_wire = instrument.kind == InstrumentKind::wire;
    const double outer_px = std::max(2.0, 2.0 * radius_mm * px_per_mm);
    const double inner_px = 2e-3 * instrument.table.knots[0].radius_inner_um * px_per_mm;
    sheet.stroke(points, outer_px, is_wire ? wire_ink : catheter_ink);
    if (inner_px > 2.5) sheet.stroke(points, inner_px, lumen_ink);
    sheet.unclip();
}

// --- sheet
// -------------------------------------------------------------------------------------------------------

void draw_legend(Sheet &sheet, int y)
{
    int x = profile_column.left;
    auto entry = [&](const std::string &text, Ink ink, double dash) {
        sheet.stroke({{x + 0.0, y + 7.0}, {x + 36.0, y + 7.0}}, 3.0, ink, dash);
        sheet.text(x + 46, y, text, 2, black);
        x += 46 + Sheet::text_width(text, 2) + 30;
    };
    entry("EI bending", bend_ink, 0.0);
    entry("GJ torsion", twist_ink, 0.0);
    entry("EI of other presets", fit_ink, 8.0);
}

void draw_head(Sheet &sheet)
{
    sheet.text(text_column.left, 14, "Instruments", 4, black);
    centred(sheet, 0.5 * (profile_column.left + profile_column.right), 14,
            "stiffness, N m^2; unchanged beyond 400 mm", 2, black);
    draw_legend(sheet, 46);
    centred(sheet, 0.5 * (tip_column.left + tip_column.right), 14, "tip, 5 mm grid", 2, black);
    centred(sheet, 0.5 * (shape_column.left + shape_column.right), 14,
            "unloaded shape, 10 mm grid, tip on the right", 2, black);
}

void draw_foot(Sheet &sheet, int y)
{
    for (int mm = 0; mm <= static_cast<int>(profile_mm); mm += 100) {
        centred(sheet, profile_x(mm), y + 4, std::to_string(mm), 2, grey);
    }
    centred(sheet, 0.5 * (profile_column.left + profile_column.right), y + 26, "mm from the tip", 2, grey);
}

} // namespace

Image instruments_picture(const std::vector<ListedInstrument> &list)
{
    const int rows_px = static_cast<int>(list.size()) * row_px;
    Sheet sheet(sheet_px, head_px + rows_px + foot_px);
    for (std::size_t i = 0; i < list.size(); i++) {
        const int top = head_px + static_cast<int>(i) * row_px;
        if (i % 2 == 0) sheet.box(0, top, sheet_px, top + row_px, band);
        const Row row = row_at(i);
        const Instrument &instrument = list[i].instrument;
        draw_figures(sheet, list[i], row);
        draw_profile(sheet, list[i], row);
        draw_grid(sheet, tip_column, row, tip_px_per_mm, 5.0);
        draw_shape(sheet, instrument, tip_column, row, tip_px_per_mm);
        draw_grid(sheet, shape_column, row, shape_px_per_mm, 10.0);
        draw_shape(sheet, instrument, shape_column, row, shape_px_per_mm);
    }
    draw_head(sheet);
    draw_foot(sheet, head_px + rows_px);
    return sheet.image();
}

} // namespace crn
