// Swept tube: smooth centreline, cylinders between bisecting planes, chords per ray.
#include "host/xray/tube.hpp"
#include <algorithm>
#include <cmath>

namespace seld
{
namespace
{

using Eigen::Vector3d;

constexpr double sagitta_max_mm = 0.01; // how far the pieces may leave the smooth centreline
constexpr int pieces_max = 12;
constexpr int grid = 3;
constexpr double near_m = 1e-5; // points of a line that are no farther apart count as one

// A point of the refined centreline in camera axes: x right, y up, z away from the source, mm.
struct Point {
    Vector3d at_mm;
    double arc_m = 0.0;
    double radius_mm = 0.0;
};

// Cylinder from a to b, cut by the planes through a and b with these normals.
struct Piece {
    Vector3d a_mm, b_mm, axis, normal_a, normal_b;
    double radius_mm = 0.0;
};

bool is_finite(const WireNode &node)
{
    return node.position_m.allFinite() && std::isfinite(node.arc_m) && std::isfinite(node.radius_m);
}

std::vector<Point> to_camera(const WireFrame &wire, const View &view)
{
    std::vector<Point> points;
    for (const WireNode &node : wire.nodes) {
        if (!is_finite(node)) break;
        Vector3d ray = (node.position_m - view.source_m) * 1e3;
        Point point{
            {ray.dot(view.right), ray.dot(view.up), ray.dot(view.forward)}, node.arc_m, node.radius_m * 1e3};
        if (!points.empty() && (points.back().at_mm - point.at_mm).norm() < 1e-4) continue;
        points.push_back(point);
    }
    return points;
}

// Cubic through the nodes with central tangents, cut where the chord would leave it.
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
                              from.radius_mm + s * (to.radius_mm - from.radius_mm)});
        }
    }
    points.push_back(nodes.back());
    return points;
}

// Where the ray o = 0, direction `ray` (unit) runs inside the piece, as a length in mm.
double chord_mm(const Piece &piece, const Vector3d &ray)
{
    const double along = ray.dot(piece.axis);
    const Vector3d across = ray - along * piece.axis;
    const Vector3d start = -piece.a_mm + piece.a_mm.dot(piece.axis) * piece.axis;
    const double a = across.squaredNorm(), b = start.dot(across);
    const double c = start.squaredNorm() - piece.radius_mm * piece.radius_mm;
    double enter = -1e9, leave = 1e9;
    if (a > 1e-12) {
        const double under_root = b * b - a * c;
        if (under_root <= 0.0) return 0.0;
        const double root = std::sqrt(under_root);
        enter = (-b - root) / a;
        leave = (-b + root) / a;
    } else if (c > 0.0) {
        return 0.0;
    }
    auto keep_side = [&](const Vector3d &point, const Vector3d &normal) { // (t ray - point) . normal >= 0
        const double slope = ray.dot(normal), bound = point.dot(normal);
        if (slope > 1e-12)
            enter = std::max(enter, bound / slope);
        else if (slope < -1e-12)
            leave = std::min(leave, bound / slope);
        else if (bound > 0.0)
            leave = enter;
    };
    keep_side(piece.a_mm, piece.normal_a);
    keep_side(piece.b_mm, -piece.normal_b);
    return std::max(leave - enter, 0.0);
}

class TubePainter
{
  public:
    TubePainter(const View &view, ToolPaths &paths)
        : paths_(paths), focal_pixels_(view.source_detector_m / view.pixel_m), half_(0.5 * view.size),
          size_(view.size)
    {
    }

    // The part of the piece between two radii, filled to the share `fill`.
    void draw(const Piece &piece, const Material material, double inner_mm, double fill)
    {
        const std::size_t own = slot(material), blood = slot(Material::blood);
        Piece hole = piece;
        hole.radius_mm = inner_mm;
        const double near_mm = std::min(piece.a_mm.z(), piece.b_mm.z()) - piece.radius_mm;
        if (near_mm < 1.0) return;
        const double ax = pixel_x(piece.a_mm), ay = pixel_y(piece.a_mm);
        const double bx = pixel_x(piece.b_mm), by = pixel_y(piece.b_mm);
        // Cylinder's rim, its cut at the bisecting planes, and a pixel's own half diagonal.
        const double pad = 1.6 * piece.radius_mm * focal_pixels_ / near_mm + 1.0;
        const int x0 = first_pixel(std::min(ax, bx) - pad), x1 = last_pixel(std::max(ax, bx) + pad);
        const int y0 = first_pixel(std::min(ay, by) - pad), y1 = last_pixel(std::max(ay, by) + pad);
        std::array<std::int32_t, tool_rays> rays;
        for (int y = y0; y <= y1; ++y)
            for (int x = x0; x <= x1; ++x) {
                if (is_far(x + 0.5, y + 0.5, ax, ay, bx, by, pad)) continue;
                if (!find_rays(piece, hole, fill, x, y, rays)) continue;
                std::int32_t *of_pixel = entry(y * size_ + x);
                for (int k = 0; k < tool_rays; ++k) {
                    of_pixel[own * tool_rays + k] += rays[k];
                    of_pixel[blood * tool_rays + k] -= rays[k];
                }
            }
    }

  private:
    double pixel_x(const Vector3d &p) const { return half_ + focal_pixels_ * p.x() / p.z(); }
    double pixel_y(const Vector3d &p) const { return half_ - focal_pixels_ * p.y() / p.z(); }
    int first_pixel(double v) const { return static_cast<int>(std::clamp(std::floor(v), 0.0, 1.0 * size_)); }
    int last_pixel(double v) const { return static_cast<int>(std::clamp(std::floor(v), -1.0, size_ - 1.0)); }

    // Farther than `pad` from the line between a and b in the picture.
    static bool is_far(double x, double y, double ax, double ay, double bx, double by, double pad)
    {
        const double dx = bx - ax, dy = by - ay, square = dx * dx + dy * dy;
        double share = square > 0.0 ? ((x - ax) * dx + (y - ay) * dy) / square : 0.0;
        share = std::clamp(share, 0.0, 1.0);
        const double ex = x - ax - share * dx, ey = y - ay - share * dy;
        return ex * ex + ey * ey > pad * pad;
    }

    // Filled chord of each ray of a pixel, in 1/1024 mm; false when all are 0.
    bool find_rays(const Piece &piece, const Piece &hole, double fill, int x, int y,
                   std::array<std::int32_t, tool_rays> &rays) const
    {
        std::int32_t any = 0;
        for (int j = 0; j < grid; ++j)
            for (int i = 0; i < grid; ++i) {
                Vector3d ray(x + (i + 0.5) / grid - half_, half_ - y - (j + 0.5) / grid, focal_pixels_);
                ray /= std::sqrt(ray.squaredNorm());
                double chord = chord_mm(piece, ray);
                if (chord > 0.0 && hole.radius_mm > 0.0) chord -= chord_mm(hole, ray);
                rays[j * grid + i] = static_cast<std::int32_t>(chord * fill * 1024.0 + 0.5);
                any |= rays[j * grid + i];
            }
        return any != 0;
    }

    std::size_t slot(Material material) const
    {
        const auto &materials = paths_.materials;
        return std::find(materials.begin(), materials.end(), material) - materials.begin();
    }

    std::int32_t *entry(int pixel)
    {
        std::int32_t &place = paths_.entry[pixel];
        if (place < 0) {
            place = static_cast<std::int32_t>(paths_.pixels.size());
            paths_.pixels.push_back(pixel);
            paths_.q10mm.resize(paths_.q10mm.size() + paths_.ints_per_pixel(), 0);
        }
        return paths_.q10mm.data() + static_cast<std::size_t>(place) * paths_.ints_per_pixel();
    }

    ToolPaths &paths_;
    double focal_pixels_, half_;
    int size_;
};

Vector3d direction(const Point &from, const Point &to)
{
    return (to.at_mm - from.at_mm).normalized();
}

Point between(const Point &from, const Point &to, double arc_m)
{
    const double share = (arc_m - from.arc_m) / (to.arc_m - from.arc_m);
    return {from.at_mm + share * (to.at_mm - from.at_mm), arc_m,
            from.radius_mm + share * (to.radius_mm - from.radius_mm)};
}

// The line from a tool's own tip on, with a point wherever one of its sections begins or ends.
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

// `fill` counts the whole cross-section within the section's radius; a tool with a lumen has it all in its wall.
void draw_section(TubePainter &painter, Piece &piece, const RadiopaqueSection &section,
                  const RadiopaqueRadius &radius)
{
    const double outer_mm = radius.outer_m * 1e3 * section.radius_share;
    double inner_mm = radius.inner_m * 1e3, fill = section.fill;
    if (outer_mm <= 0.0) return;
    if (inner_mm >= outer_mm) inner_mm = 0.0; // something thin inside the lumen
    fill = std::min(1.0, fill * outer_mm * outer_mm / (outer_mm * outer_mm - inner_mm * inner_mm));
    piece.radius_mm = outer_mm;
    painter.draw(piece, section.material, inner_mm, fill);
}

void draw_tool(TubePainter &painter, const RadiopaqueInstrument &tool, const std::vector<Point> &points,
               double tip_arc_m)
{
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        Piece piece;
        piece.a_mm = points[i].at_mm;
        piece.b_mm = points[i + 1].at_mm;
        piece.axis = direction(points[i], points[i + 1]);
        const Vector3d before = i > 0 ? direction(points[i - 1], points[i]) : piece.axis;
        const Vector3d after = i + 2 < points.size() ? direction(points[i + 1], points[i + 2]) : piece.axis;
        piece.normal_a = (before + piece.axis).normalized();
        piece.normal_b = (piece.axis + after).normalized();
        const double arc_m = 0.5 * (points[i].arc_m + points[i + 1].arc_m) - tip_arc_m;
        const RadiopaqueRadius radius =
            radius_at(tool, arc_m, 0.5 * (points[i].radius_mm + points[i + 1].radius_mm));
        for (const RadiopaqueSection &section : tool.sections) {
            if (arc_m < section.arc_begin_m || arc_m >= section.arc_end_m) continue;
            draw_section(painter, piece, section, radius);
        }
    }
}

// Empty paths of this size, with a place for every material that the tools name.
void restart(ToolPaths &paths, int size, std::span<const RadiopaqueInstrument> tools)
{
    if (paths.size == size)
        for (std::int32_t pixel : paths.pixels) paths.entry[pixel] = -1;
    else
        paths.entry.assign(static_cast<std::size_t>(size) * size, -1);
    paths.size = size;
    paths.pixels.clear();
    paths.q10mm.clear();
    paths.materials = {Material::blood};
    for (const RadiopaqueInstrument &tool : tools)
        for (const RadiopaqueSection &section : tool.sections) {
            auto &known = paths.materials;
            if (std::find(known.begin(), known.end(), section.material) == known.end())
                known.push_back(section.material);
        }
}

} // namespace

void draw_tools(std::span<const RadiopaqueInstrument> tools, const WireFrame &wire, const View &view,
                ToolPaths &paths)
{
    restart(paths, view.size, tools);
    const std::vector<Point> nodes = to_camera(wire, view);
    if (nodes.size() < 2) return;
    const std::vector<Point> line = refine(nodes);
    TubePainter painter(view, paths);
    for (std::size_t k = 0; k < tools.size(); ++k) {
        const double tip_arc_m = k < wire.tip_arc_m.size() ? wire.tip_arc_m[k] : 0.0;
        if (!std::isfinite(tip_arc_m)) continue;
        draw_tool(painter, tools[k], own_part(line, tip_arc_m, tools[k]), tip_arc_m);
    }
}

RadiopaqueInstrument guidewire_look(double tip_m)
{
    // The coil's wire fills about three quarters of its tube's wall; with the core, .75 of the cross-section is steel.
    // A platinum tip coil around a ground-down core: 15 % platinum is already darker than solid steel.
    return {{{0.0, tip_m, Material::platinum, 0.15, 1.0},
             {0.0, tip_m, Material::steel, 0.45, 1.0},
             {tip_m, 10.0, Material::steel, 0.75, 1.0}},
            {}};
}

} // namespace seld
