// Converts the tools' common centreline and the curves of struts and contrast medium to short cylinders,
// which are cut by bisecting planes where they meet.
#include "host/xray/paths/tube.hpp"
#include "host/xray/paths/tube_faint.hpp"
#include "host/xray/paths/tube_painter.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

using Eigen::Vector3d;

constexpr double sagitta_max_mm = 0.01; // largest distance of the pieces from the smooth centreline
constexpr int pieces_max = 12;
constexpr double near_m = 1e-5; // points of a line that are closer than this count as one

// Describes a point of the refined centreline in camera axes: x right, y up, z away from the source, mm.
struct Point {
    Vector3d at_mm;
    double arc_m = 0.0;
    double radius_mm = 0.0;
    double share = 1.0;    // of a curve's cross-section
    double contrast = 0.0; // share of iohexol 350 in the surrounding blood
};

bool is_finite(const WireNode &node)
{
    return node.position_m.allFinite() && std::isfinite(node.arc_m) && std::isfinite(node.radius_m) &&
           std::isfinite(node.contrast_mg_per_ml);
}

std::vector<Point> to_camera(const WireFrame &wire, const View &view)
{
    std::vector<Point> points;
    for (const WireNode &node : wire.nodes) {
        if (!is_finite(node)) break;
        Vector3d ray = (node.position_m - view.source_m) * 1e3;
        Point point{{ray.dot(view.right), ray.dot(view.up), ray.dot(view.forward)},
                    node.arc_m,
                    node.radius_m * 1e3,
                    1.0,
                    contrast_share(node.contrast_mg_per_ml)};
        if (!points.empty() && (points.back().at_mm - point.at_mm).norm() < 1e-4) continue;
        points.push_back(point);
    }
    return points;
}

// Fits a cubic curve with central tangents through the nodes, and divides the curve where a straight piece
// would deviate from it too far.
std::vector<Point> refine(const std::vector<Point> &nodes)
{
    std::vector<Point> points;
    const std::size_t count = nodes.size();
    auto tangent = [&](std::size_t i) -> Vector3d { // per unit of chord length
        const Point &before = nodes[i == 0 ? 0 : i - 1], &after = nodes[std::min(i + 1, count - 1)];
        double length = (nodes[i].at_mm - before.at_mm).norm() + (after.at_mm - nodes[i].at_mm).norm();
        return (after.at_mm - before.at_mm) / length;
    };
    for (std::size_t i = 0; i + 1 < count; ++i) {
        const Point &from = nodes[i], &to = nodes[i + 1];
        const double length = (to.at_mm - from.at_mm).norm();
        const Vector3d t0 = tangent(i) * length, t1 = tangent(i + 1) * length;
        const double sagitta = (t1 - t0).norm() / 8.0;
        int pieces = 1;
        while (pieces < pieces_max && sagitta > sagitta_max_mm * pieces * pieces) ++pieces;
        for (int k = 0; k < pieces; ++k) {
            const double s = static_cast<double>(k) / pieces, s2 = s * s, s3 = s2 * s;
            Vector3d at = (2 * s3 - 3 * s2 + 1) * from.at_mm + (s3 - 2 * s2 + s) * t0 +
                          (3 * s2 - 2 * s3) * to.at_mm + (s3 - s2) * t1;
            points.push_back({at, from.arc_m + s * (to.arc_m - from.arc_m),
                              from.radius_mm + s * (to.radius_mm - from.radius_mm), 1.0,
                              from.contrast + s * (to.contrast - from.contrast)});
        }
    }
    points.push_back(nodes.back());
    return points;
}

Vector3d direction(const Point &from, const Point &to)
{
    return (to.at_mm - from.at_mm).normalized();
}

Point between(const Point &from, const Point &to, double arc_m)
{
    const double share = (arc_m - from.arc_m) / (to.arc_m - from.arc_m);
    return {from.at_mm + share * (to.at_mm - from.at_mm), arc_m,
            from.radius_mm + share * (to.radius_mm - from.radius_mm), 1.0,
            from.contrast + share * (to.contrast - from.contrast)};
}

// Returns the part of the common centreline that a tool covers, from its tip on, with a point wherever one of
// the tool's sections begins or ends.
std::vector<Point> own_part(const std::vector<Point> &line, double tip_arc_m,
                            const RadiopaqueInstrument &tool)
{
    std::vector<double> marks_m = {tip_arc_m};
    for (const RadiopaqueSection &section : tool.sections) {
        marks_m.push_back(tip_arc_m + section.arc_begin_m);
        marks_m.push_back(tip_arc_m + section.arc_end_m);
    }
    std::sort(marks_m.begin(), marks_m.end());
    std::vector<Point> points;
    auto is_new = [&](double arc_m) { return points.empty() || arc_m > points.back().arc_m + near_m; };
    std::size_t mark = 0;
    for (std::size_t i = 0; i < line.size(); ++i) {
        for (; mark < marks_m.size() && marks_m[mark] < line[i].arc_m - near_m; ++mark) {
            const double arc_m = marks_m[mark];
            if (i > 0 && arc_m > line[i - 1].arc_m + near_m && arc_m >= tip_arc_m && is_new(arc_m))
                points.push_back(between(line[i - 1], line[i], arc_m));
        }
        if (line[i].arc_m >= tip_arc_m - near_m) points.push_back(line[i]);
    }
    return points;
}

RadiopaqueRadius radius_at(const RadiopaqueInstrument &tool, double arc_m, double node_radius_mm)
{
    const std::vector<RadiopaqueRadius> &radii = tool.radii;
    if (radii.empty()) return {arc_m, node_radius_mm * 1e-3, 0.0};
    const auto after = std::upper_bound(radii.begin(), radii.end(), arc_m,
                                        [](double arc, const RadiopaqueRadius &r) { return arc < r.arc_m; });
    if (after == radii.begin()) return radii.front();
    const RadiopaqueRadius &before = after[-1];
    if (after == radii.end()) return before;
    const double share = (arc_m - before.arc_m) / (after->arc_m - before.arc_m);
    return {arc_m, before.outer_m + share * (after->outer_m - before.outer_m),
            before.inner_m + share * (after->inner_m - before.inner_m)};
}

// Returns the cylinder from points[i] to the next point, cut by the planes where the cylinder meets its
// neighbours. At a sharp bend the cylinder is cut perpendicular to its own axis.
TubePiece piece_between(const std::vector<Point> &points, std::size_t i)
{
    TubePiece piece;
    piece.a_mm = points[i].at_mm;
    piece.b_mm = points[i + 1].at_mm;
    const Vector3d axis = direction(points[i], points[i + 1]);
    const Vector3d before = i > 0 ? direction(points[i - 1], points[i]) : axis;
    const Vector3d after = i + 2 < points.size() ? direction(points[i + 1], points[i + 2]) : axis;
    auto halving = [&](const Vector3d &other) -> Vector3d {
        const Vector3d sum = axis + other;
        return sum.squaredNorm() > 1.0 ? sum.normalized() : axis;
    };
    piece.normal_a = halving(before);
    piece.normal_b = halving(after);
    piece.displaced_contrast = 0.5 * (points[i].contrast + points[i + 1].contrast);
    return piece;
}

// The filled fraction of a section that reaches down to the lumen refers to the tool's whole cross-section,
// although all material is in the wall. The filled fraction of a ring refers to the ring's own cross-section.
void draw_section(TubePainter &painter, TubePiece &piece, const RadiopaqueSection &section,
                  const RadiopaqueRadius &radius)
{
    const double tool_mm = radius.outer_m * 1e3, lumen_mm = radius.inner_m * 1e3;
    piece.outer_mm = tool_mm * section.radius_share;
    piece.inner_mm = std::max(lumen_mm, tool_mm * section.inner_radius_share);
    piece.share = section.fill;
    piece.material = section.material;
    if (piece.outer_mm <= 0.0) return;
    if (piece.inner_mm >= piece.outer_mm) {
        if (section.inner_radius_share > 0.0) return;
        piece.inner_mm = 0.0; // something thin inside the lumen
    }
    const double outer_square = piece.outer_mm * piece.outer_mm,
                 inner_square = piece.inner_mm * piece.inner_mm;
    if (!(section.inner_radius_share > 0.0)) piece.share *= outer_square / (outer_square - inner_square);
    piece.share = std::min(piece.share, 1.0);
    painter.paint(piece);
}

void draw_tool(TubePainter &painter, const RadiopaqueInstrument &tool, const std::vector<Point> &points,
               double tip_arc_m)
{
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        TubePiece piece = piece_between(points, i);
        const double arc_m = 0.5 * (points[i].arc_m + points[i + 1].arc_m) - tip_arc_m;
        const RadiopaqueRadius radius =
            radius_at(tool, arc_m, 0.5 * (points[i].radius_mm + points[i + 1].radius_mm));
        for (const RadiopaqueSection &section : tool.sections)
            if (arc_m >= section.arc_begin_m && arc_m < section.arc_end_m)
                draw_section(painter, piece, section, radius);
    }
}

// Returns the points of a curve in camera axes; returns an empty list if any point is not finite.
std::vector<Point> to_camera(const SweptCurve &curve, const View &view)
{
    std::vector<Point> points;
    for (const SweptPoint &at : curve.points) {
        if (!at.at_m.allFinite() || !std::isfinite(at.radius_m) || !std::isfinite(at.share)) return {};
        const Vector3d ray = (at.at_m - view.source_m) * 1e3;
        Point point{{ray.dot(view.right), ray.dot(view.up), ray.dot(view.forward)},
                    0.0,
                    at.radius_m * 1e3,
                    std::clamp(at.share, 0.0, 1.0),
                    0.0};
        if (points.empty() || (points.back().at_mm - point.at_mm).norm() >= 1e-4) points.push_back(point);
    }
    return points;
}

// The pieces of a conical curve are drawn as cylinders of equal volume.
void draw_curve(TubePainter &painter, FaintMedium &faint, const SweptCurve &curve, const View &view)
{
    const std::vector<Point> points = to_camera(curve, view);
    if (curve.points.size() == 1 && !points.empty())
        faint.ball(points[0].at_mm, points[0].radius_mm, points[0].share);
    for (std::size_t i = 0; curve.is_fine && i + 1 < points.size(); ++i)
        faint.line(points[i].at_mm, points[i + 1].at_mm,
                   0.5 * (points[i].radius_mm + points[i + 1].radius_mm),
                   0.5 * (points[i].share + points[i + 1].share));
    if (curve.is_fine) return;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        TubePiece piece = piece_between(points, i);
        const double from = std::max(points[i].radius_mm, 0.0), to = std::max(points[i + 1].radius_mm, 0.0);
        piece.outer_mm = std::sqrt((from * from + from * to + to * to) / 3.0);
        piece.share = 0.5 * (points[i].share + points[i + 1].share);
        piece.material = curve.material;
        painter.paint(piece);
    }
}

void draw_line(TubePainter &painter, const XrayFrame &frame, const View &view)
{
    const std::vector<Point> nodes = to_camera(frame.wire, view);
    if (nodes.size() < 2) return;
    const std::vector<Point> line = refine(nodes);
    for (std::size_t k = 0; k < frame.tools.size(); ++k) {
        const double tip_arc_m = k < frame.wire.tip_arc_m.size() ? frame.wire.tip_arc_m[k] : 0.0;
        if (!std::isfinite(tip_arc_m)) continue;
        const bool is_labelled = frame.labels != nullptr && k < frame.labels->tool_bits.size();
        painter.label(frame.labels, is_labelled ? frame.labels->tool_bits[k] : std::uint8_t{0}, false);
        draw_tool(painter, frame.tools[k], own_part(line, tip_arc_m, frame.tools[k]), tip_arc_m);
    }
}

void begin_labels(TubeLabels &labels, int size)
{
    const std::size_t pixels = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
    labels.pixels.assign(pixels, 0);
    labels.sums_q10mm.resize(pixels, 0);
}

// Sets the label bit of each pixel whose sum of path lengths reaches the threshold, and resets all sums to 0.
void end_sums(TubeLabels &labels, const LabelledCurves &run)
{
    for (const std::int32_t pixel : labels.summed) {
        std::int32_t &sum = labels.sums_q10mm[static_cast<std::size_t>(pixel)];
        if (sum >= run.sum_min_q10mm) labels.pixels[static_cast<std::size_t>(pixel)] |= run.bit;
        sum = 0;
    }
    labels.summed.clear();
}

void draw_curves(TubePainter &painter, const XrayFrame &frame, const View &view, std::vector<float> &haze_mm)
{
    FaintMedium faint(view);
    std::span<const SweptCurve> rest = frame.curves;
    if (frame.labels != nullptr)
        for (const LabelledCurves &run : frame.labels->curves) {
            const std::size_t count = std::min(run.count, rest.size());
            const bool is_summed = run.sum_min_q10mm > 0;
            painter.label(frame.labels, run.bit, is_summed);
            for (const SweptCurve &curve : rest.first(count)) draw_curve(painter, faint, curve, view);
            if (is_summed) end_sums(*frame.labels, run);
            rest = rest.subspan(count);
        }
    painter.label(nullptr, 0, false);
    for (const SweptCurve &curve : rest) draw_curve(painter, faint, curve, view);
    faint.finish(haze_mm);
}

} // namespace

void draw_tubes(const XrayFrame &frame, const View &view, Material displaced, ToolPaths &paths)
{
    std::vector<Material> materials;
    for (const RadiopaqueInstrument &tool : frame.tools)
        for (const RadiopaqueSection &section : tool.sections) materials.push_back(section.material);
    for (const SweptCurve &curve : frame.curves) materials.push_back(curve.material);
    if (frame.labels != nullptr) begin_labels(*frame.labels, view.size);
    TubePainter painter(view, materials, displaced, paths);
    draw_line(painter, frame, view);
    draw_curves(painter, frame, view, paths.haze_mm);
    painter.finish();
}

double contrast_share(double iodine_mg_per_ml)
{
    return std::clamp(iodine_mg_per_ml / 350.0, 0.0, 1.0);
}

RadiopaqueInstrument guidewire_look(double tip_m)
{
    // The wire of a coil fills about three quarters of the tube that represents it; together with the core,
    // 75 % of the cross-section is steel. At the guidewire's tip a platinum coil surrounds a core that is
    // ground down; 15 % of platinum is already darker than solid steel.
    return {{{0.0, tip_m, Material::platinum, 0.15, 1.0},
             {0.0, tip_m, Material::steel, 0.45, 1.0},
             {tip_m, 10.0, Material::steel, 0.75, 1.0}},
            {}};
}

} // namespace crn
