// Draws without a graphics processor: first the transparent vessel, then the spheres from far to near, and
// then points and letters.
#include "tools/centreline/fit/tree_picture.hpp"
#include "host/base/format.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace crn::centreline
{
namespace
{

constexpr Ink wall_ink{96, 120, 150}, sphere_ink{40, 110, 190}, line_ink{16, 44, 84}, manual_ink{214, 32, 32},
    letter_ink{30, 30, 40};
constexpr double rad_per_deg = 3.14159265358979323846 / 180;

// Draws a sphere of the tree as a translucent ball whose rim is darker than its middle.
void draw_ball(Sheet &sheet, const SheetPoint &at, double radius_px, Ink ink, double share)
{
    const double reach = radius_px + 1;
    for (int y = static_cast<int>(at.y - reach); y <= at.y + reach; ++y)
        for (int x = static_cast<int>(at.x - reach); x <= at.x + reach; ++x) {
            const double distance = std::hypot(x + 0.5 - at.x, y + 0.5 - at.y);
            const double cover = std::clamp(radius_px + 0.5 - distance, 0.0, 1.0);
            if (cover <= 0) continue;
            const double rim = std::min(1.0, distance / std::max(radius_px, 1e-6));
            sheet.blend(x, y, ink, cover * share * (0.35 + 0.65 * std::pow(rim, 4)));
        }
}

void draw_dot(Sheet &sheet, const SheetPoint &at, double radius_px, Ink ink)
{
    const double reach = radius_px + 1;
    for (int y = static_cast<int>(at.y - reach); y <= at.y + reach; ++y)
        for (int x = static_cast<int>(at.x - reach); x <= at.x + reach; ++x) {
            const double distance = std::hypot(x + 0.5 - at.x, y + 0.5 - at.y);
            // The drawing brightens the ball's upper left, so that the ball looks round.
            const double light =
                std::hypot(x + 0.5 - at.x + 0.35 * radius_px, y + 0.5 - at.y + 0.35 * radius_px);
            const double bright = std::max(0.0, 1 - light / (0.8 * radius_px));
            const auto lit = [&](std::uint8_t c) {
                return static_cast<std::uint8_t>(c + (255 - c) * 0.7 * bright);
            };
            sheet.blend(x, y, {lit(ink.red), lit(ink.green), lit(ink.blue)},
                        std::clamp(radius_px + 0.5 - distance, 0.0, 1.0));
        }
}

void draw_line(Sheet &sheet, const SheetPoint &a, const SheetPoint &b, double width, Ink ink)
{
    const int reach = static_cast<int>(width) + 2;
    sheet.clip(static_cast<int>(std::min(a.x, b.x)) - reach, static_cast<int>(std::min(a.y, b.y)) - reach,
               static_cast<int>(std::max(a.x, b.x)) + reach, static_cast<int>(std::max(a.y, b.y)) + reach);
    sheet.stroke({a, b}, width, ink);
    sheet.unclip();
}

// For each pixel whose centre lies in a triangle, calls use() with the barycentric coordinates of this
// centre.
template <typename Use> void each_pixel(const std::array<SheetPoint, 3> &c, const View &view, Use use)
{
    const double area = (c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[2].x - c[0].x) * (c[1].y - c[0].y);
    if (std::abs(area) < 1e-9) return;
    const auto bound = [](double value, int most) {
        return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(most)));
    };
    const int x0 = bound(std::floor(std::min({c[0].x, c[1].x, c[2].x})), view.width - 1),
              x1 = bound(std::ceil(std::max({c[0].x, c[1].x, c[2].x})), view.width - 1),
              y0 = bound(std::floor(std::min({c[0].y, c[1].y, c[2].y})), view.height - 1),
              y1 = bound(std::ceil(std::max({c[0].y, c[1].y, c[2].y})), view.height - 1);
    for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) {
            const double px = x + 0.5, py = y + 0.5;
            const double u = ((c[1].x - px) * (c[2].y - py) - (c[2].x - px) * (c[1].y - py)) / area,
                         v = ((c[2].x - px) * (c[0].y - py) - (c[0].x - px) * (c[2].y - py)) / area;
            if (u >= 0 && v >= 0 && u + v <= 1) use(x, y, u, v);
        }
}

void draw_scale(Sheet &sheet, const View &view)
{
    double length_mm = 1;
    for (double step : {2.0, 5.0, 10.0, 20.0, 50.0, 100.0})
        if (step * view.pixels_per_mm < 0.3 * view.width) length_mm = step;
    const double y = view.height - 18, x = 16, end = x + length_mm * view.pixels_per_mm;
    draw_line(sheet, {x, y}, {end, y}, 3, letter_ink);
    const std::string text = formatted("%g mm", length_mm);
    sheet.text(static_cast<int>(x), static_cast<int>(y) - 24, text, 2, letter_ink);
}

} // namespace

Eigen::Matrix3d View::axes() const
{
    const Eigen::Matrix3d turned = (Eigen::AngleAxisd(tilt_deg * rad_per_deg, Eigen::Vector3d::UnitX()) *
                                    Eigen::AngleAxisd(-turn_deg * rad_per_deg, Eigen::Vector3d::UnitY()))
                                       .toRotationMatrix();
    return turned;
}

SheetPoint View::place(const Eigen::Vector3d &p_mm) const
{
    const Eigen::Vector3d seen = axes() * (p_mm - middle_mm);
    return {width / 2.0 + seen.x() * pixels_per_mm, height / 2.0 - seen.y() * pixels_per_mm};
}

Eigen::Vector3d View::ray_start_mm(double x, double y) const
{
    return middle_mm + axes().transpose() * Eigen::Vector3d((x - width / 2.0) / pixels_per_mm,
                                                            (height / 2.0 - y) / pixels_per_mm, 0);
}

View view_of(const bake::Mesh &mesh, double turn_deg, double tilt_deg, int width, int height)
{
    View view;
    view.turn_deg = turn_deg;
    view.tilt_deg = tilt_deg;
    view.width = width;
    view.height = height;
    Eigen::AlignedBox3d seen;
    const Eigen::Matrix3d axes = view.axes();
    for (const Eigen::Vector3d &v : mesh.vertices_mm) seen.extend(axes * v);
    view.middle_mm = axes.transpose() * seen.center();
    view.pixels_per_mm =
        0.9 * std::min(width / std::max(seen.sizes().x(), 1.0), height / std::max(seen.sizes().y(), 1.0));
    return view;
}

std::vector<float> glass_of(const bake::Mesh &mesh, const View &view)
{
    const Eigen::Matrix3d axes = view.axes();
    std::vector<Eigen::Vector3d> normals(mesh.vertices_mm.size(), Eigen::Vector3d::Zero());
    for (const bake::Triangle &t : mesh.triangles) {
        const Eigen::Vector3d a = mesh.vertices_mm[t[0]];
        const Eigen::Vector3d normal = (mesh.vertices_mm[t[1]] - a).cross(mesh.vertices_mm[t[2]] - a);
        for (std::uint32_t v : t) normals[v] += normal;
    }
    std::vector<SheetPoint> places;
    std::vector<float> slant; // how far the wall turns away from the viewer: 1 at the outline
    for (std::size_t v = 0; v < normals.size(); ++v) {
        const Eigen::Vector3d seen = axes * (mesh.vertices_mm[v] - view.middle_mm);
        places.push_back({view.width / 2.0 + seen.x() * view.pixels_per_mm,
                          view.height / 2.0 - seen.y() * view.pixels_per_mm});
        const double facing = normals[v].norm() > 0 ? std::abs((axes * normals[v].normalized()).z()) : 1;
        slant.push_back(static_cast<float>(1 - facing));
    }
    std::vector<float> glass(static_cast<std::size_t>(view.width) * view.height, 0.0f);
    for (const bake::Triangle &t : mesh.triangles)
        each_pixel({places[t[0]], places[t[1]], places[t[2]]}, view, [&](int x, int y, double u, double v) {
            const double graze = u * slant[t[0]] + v * slant[t[1]] + (1 - u - v) * slant[t[2]];
            float &pixel = glass[static_cast<std::size_t>(y) * view.width + x];
            pixel = std::max(pixel, static_cast<float>(0.14 + 0.66 * graze * graze * graze));
        });
    return glass;
}

namespace
{

// Draws each edge of the mesh once, from far to near; edges far from the viewer are paler.
void draw_wires(Sheet &sheet, const View &view, const bake::Mesh &mesh)
{
    const Eigen::Matrix3d axes = view.axes();
    struct Edge {
        double depth_mm;
        std::uint32_t from, to;
    };
    std::vector<Edge> edges;
    double nearest_mm = -1e9, farthest_mm = 1e9;
    for (const bake::Triangle &t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t from = t[k], to = t[(k + 1) % 3];
            if (from > to) continue; // the neighbouring triangle has this edge in the other direction
            const double depth_mm = (axes * (mesh.vertices_mm[from] + mesh.vertices_mm[to])).z() / 2;
            edges.push_back({depth_mm, from, to});
            nearest_mm = std::max(nearest_mm, depth_mm);
            farthest_mm = std::min(farthest_mm, depth_mm);
        }
    std::stable_sort(edges.begin(), edges.end(),
                     [](const Edge &a, const Edge &b) { return a.depth_mm < b.depth_mm; });
    for (const Edge &edge : edges) {
        const double share = (edge.depth_mm - farthest_mm) / std::max(nearest_mm - farthest_mm, 1e-9);
        const auto grey = static_cast<std::uint8_t>(215 - 185 * share);
        draw_line(sheet, view.place(mesh.vertices_mm[edge.from]), view.place(mesh.vertices_mm[edge.to]), 1.0,
                  {grey, grey, grey});
    }
}

} // namespace

Sheet draw_tree(const std::vector<float> &glass, const View &view, const TreeDrawing &drawing)
{
    Sheet sheet(view.width, view.height);
    for (int y = 0; y < view.height; ++y)
        for (int x = 0; x < view.width; ++x) {
            const float share = glass[static_cast<std::size_t>(y) * view.width + x];
            if (share > 0) sheet.blend(x, y, wall_ink, share);
        }
    if (drawing.wires) draw_wires(sheet, view, *drawing.wires);
    const Eigen::Matrix3d axes = view.axes();
    if (drawing.tree) {
        std::vector<std::pair<double, const Sphere *>> spheres;
        for (const Branch &branch : drawing.tree->branches)
            for (std::size_t i = branch.parent >= 0; i < branch.spheres.size(); ++i)
                spheres.emplace_back((axes * branch.spheres[i].centre_mm).z(), &branch.spheres[i]);
        std::stable_sort(spheres.begin(), spheres.end(),
                         [](const auto &a, const auto &b) { return a.first < b.first; });
        for (const auto &[depth, sphere] : spheres)
            draw_ball(sheet, view.place(sphere->centre_mm), sphere->radius_mm * view.pixels_per_mm,
                      sphere_ink, 0.4);
        for (const Branch &branch : drawing.tree->branches)
            for (std::size_t i = 1; i < branch.spheres.size(); ++i)
                draw_line(sheet, view.place(branch.spheres[i - 1].centre_mm),
                          view.place(branch.spheres[i].centre_mm), 1.6, line_ink);
        for (const auto &[depth, sphere] : spheres)
            if (sphere->is_manual) draw_dot(sheet, view.place(sphere->centre_mm), 5, manual_ink);
    }
    for (std::size_t i = 0; drawing.points && i < drawing.points->size(); ++i) {
        const Point &point = (*drawing.points)[i];
        const SheetPoint at = view.place(point.position_mm);
        if (static_cast<int>(i) == drawing.chosen) draw_dot(sheet, at, 9, {250, 190, 40});
        draw_dot(sheet, at, 6, manual_ink);
        const std::string letter = point.kind == PointKind::start ? "S"
                                   : point.kind == PointKind::end ? "E"
                                                                  : "B";
        const std::string label =
            (drawing.with_names || static_cast<int>(i) == drawing.chosen) && !point.name.empty() ? point.name
                                                                                                 : letter;
        sheet.text(static_cast<int>(at.x) + 9, static_cast<int>(at.y) - 7, label, 2, letter_ink);
    }
    if (drawing.with_scale) draw_scale(sheet, view);
    return sheet;
}

} // namespace crn::centreline
