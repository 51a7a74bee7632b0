#include "host/xray/style/surface.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

constexpr int subpixels = 16;
constexpr double reach_pixels = 16000.0; // corners farther off are not drawn: products stay below 2^63

struct Edge {
    std::int64_t value, step_x, step_y;
    bool is_top_left;

    // Computes the edge function of the edge from corner a to corner b, at the centre of pixel (x, y). The
    // edge function is positive inside a triangle of positive area.
    Edge(const SurfaceCorner &a, const SurfaceCorner &b, int x, int y)
    {
        const std::int64_t dx = b.x - a.x, dy = b.y - a.y;
        is_top_left = dy < 0 || (dy == 0 && dx > 0);
        const std::int64_t px = x * subpixels + subpixels / 2, py = y * subpixels + subpixels / 2;
        value = dx * (py - a.y) - dy * (px - a.x);
        step_x = -dy * subpixels;
        step_y = dx * subpixels;
    }
    bool holds(std::int64_t at) const { return at > 0 || (at == 0 && is_top_left); }
};

int first_pixel(std::int32_t low)
{
    return (low + subpixels / 2 - 1) >> 4; // the first centre at or beyond `low`
}

} // namespace

SurfaceCorner surface_corner(const View &view, const Eigen::Vector3d &point_m, std::int32_t value_q16)
{
    SurfaceCorner corner;
    Eigen::Vector2d pixel;
    if (!project(view, point_m, pixel) || pixel.cwiseAbs().maxCoeff() > reach_pixels) return corner;
    corner.x = static_cast<std::int32_t>(std::floor(pixel.x() * subpixels + 0.5));
    corner.y = static_cast<std::int32_t>(std::floor(pixel.y() * subpixels + 0.5));
    corner.value_q16 = value_q16;
    corner.is_seen = true;
    return corner;
}

void add_surface(const std::array<SurfaceCorner, 3> &corners, int size, int row_begin, int row_end,
                 std::int32_t *sums)
{
    const SurfaceCorner &a = corners[0];
    SurfaceCorner b = corners[1], c = corners[2];
    if (!a.is_seen || !b.is_seen || !c.is_seen) return;
    std::int64_t area = static_cast<std::int64_t>(b.x - a.x) * (c.y - a.y) -
                        static_cast<std::int64_t>(b.y - a.y) * (c.x - a.x);
    if (area == 0) return;
    if (area < 0) {
        std::swap(b, c);
        area = -area;
    }
    const auto [low_x, high_x] = std::minmax({a.x, b.x, c.x});
    const auto [low_y, high_y] = std::minmax({a.y, b.y, c.y});
    const int x0 = std::max(0, first_pixel(low_x)), x1 = std::min(size - 1, first_pixel(high_x));
    const int y0 = std::max(row_begin, first_pixel(low_y)), y1 = std::min(row_end - 1, first_pixel(high_y));
    if (x0 > x1 || y0 > y1) return;
    Edge ab(a, b, x0, y0), bc(b, c, x0, y0), ca(c, a, x0, y0);
    for (int y = y0; y <= y1; ++y) {
        std::int64_t of_c = ab.value, of_a = bc.value,
                     of_b = ca.value; // each edge's value is the opposite corner's share
        for (int x = x0; x <= x1; ++x) {
            if (ab.holds(of_c) && bc.holds(of_a) && ca.holds(of_b))
                sums[static_cast<std::ptrdiff_t>(y) * size + x] += static_cast<std::int32_t>(
                    (of_a * a.value_q16 + of_b * b.value_q16 + of_c * c.value_q16) / area);
            of_c += ab.step_x;
            of_a += bc.step_x;
            of_b += ca.step_x;
        }
        ab.value += ab.step_y;
        bc.value += bc.step_y;
        ca.value += ca.step_y;
    }
}

} // namespace crn
