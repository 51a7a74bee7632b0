// Triangles that reach far outside the picture or behind the source are drawn here, pixel by pixel, with
// 64-bit numbers.
#include "host/xray/paths/raster.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

float dot(const Eigen::Vector3f &a, float x, float y, float z)
{
    return a.x() * x + a.y() * y + a.z() * z;
}

// Holds a corner's position in the picture before rounding, and its depth.
struct Projected {
    float x, y, depth_um;
};

Projected project_um(const Camera &camera, const Eigen::Vector3f &vertex_um)
{
    const float x = vertex_um.x() - camera.source.x();
    const float y = vertex_um.y() - camera.source.y();
    const float z = vertex_um.z() - camera.source.z();
    const float depth = dot(camera.forward, x, y, z);
    const float scale = camera.focal_pixels / depth;
    return {camera.half_pixels + dot(camera.right, x, y, z) * scale,
            camera.half_pixels - dot(camera.up, x, y, z) * scale, depth};
}

// Within guard_pixels a corner is rounded like the corners in TileRaster, because a neighbouring triangle may
// have the same corner. The coordinates of a corner outside guard_pixels are limited to +-4 million pixels,
// so that products of differences of coordinates fit into 64 bits.
std::int32_t snap_far(float pixels)
{
    if (std::fabs(pixels) <= guard_pixels) return snap(pixels);
    const double held = std::clamp(static_cast<double>(pixels), -4e6, 4e6);
    return static_cast<std::int32_t>(std::floor(held * subpixels + 0.5));
}

Corner corner(const Projected &p)
{
    return {snap_far(p.x), snap_far(p.y), 1.0f / p.depth_um};
}

// Computes the edge function of the edge from corner a to corner b, which is positive on the inner side of
// the triangle. An object of this class holds the edge function's value at the middle of a pixel, and the
// changes from there to the next column and the next row.
struct Edge {
    std::int64_t row, step_x, step_y;

    Edge(const Corner &a, const Corner &b, std::int32_t x, std::int32_t y)
    {
        const std::int64_t dx = static_cast<std::int64_t>(b.x) - a.x,
                           dy = static_cast<std::int64_t>(b.y) - a.y;
        const bool is_top_left = dy < 0 || (dy == 0 && dx > 0);
        row = dx * (static_cast<std::int64_t>(y) - a.y) - dy * (static_cast<std::int64_t>(x) - a.x) -
              (is_top_left ? 0 : 1);
        step_x = -dy * subpixels;
        step_y = dx * subpixels;
    }
    // Reduces the range [first, last] of columns to those on the inner side of the edge.
    void narrow(std::int64_t &first, std::int64_t &last) const
    {
        if (step_x > 0) {
            if (row < 0) first = std::max(first, (-row + step_x - 1) / step_x);
        } else if (row < 0) {
            last = -1;
        } else if (step_x < 0) {
            last = std::min(last, row / -step_x);
        }
    }
};

// Describes 1/depth over the picture as a plane. The values of 1/depth are limited to the range between the
// corners' values, so that a very thin triangle gives no extreme depth.
struct DepthPlane {
    float origin, slope_x, slope_y, low, high;
    std::int32_t x, y;

    DepthPlane(const Corner &a, const Corner &b, const Corner &c, float area)
    {
        const float ab = b.inverse_depth_per_um - a.inverse_depth_per_um;
        const float ac = c.inverse_depth_per_um - a.inverse_depth_per_um;
        const float per_area = 1.0f / area;
        slope_x = (ab * static_cast<float>(c.y - a.y) - ac * static_cast<float>(b.y - a.y)) * per_area;
        slope_y = (ac * static_cast<float>(b.x - a.x) - ab * static_cast<float>(c.x - a.x)) * per_area;
        origin = a.inverse_depth_per_um;
        low = std::min({a.inverse_depth_per_um, b.inverse_depth_per_um, c.inverse_depth_per_um});
        high = std::max({a.inverse_depth_per_um, b.inverse_depth_per_um, c.inverse_depth_per_um});
        x = a.x;
        y = a.y;
    }
    std::int32_t depth_q10mm(float row_value, std::int32_t at_x) const
    {
        float inverse = row_value + slope_x * static_cast<float>(at_x - x);
        inverse = inverse < low ? low : inverse;
        inverse = inverse > high ? high : inverse;
        return static_cast<std::int32_t>(q10mm_per_um / inverse + 0.5f);
    }
};

// Returns the pixels of the tile whose middles lie in the triangle's bounding box.
PixelRect pixels_inside(const Corner &a, const Corner &b, const Corner &c, const PixelRect &tile)
{
    constexpr int half = subpixels / 2;
    auto [min_x, max_x] = std::minmax({a.x, b.x, c.x});
    auto [min_y, max_y] = std::minmax({a.y, b.y, c.y});
    return {std::max((min_x + half - 1) >> subpixel_bits, tile.x0),
            std::max((min_y + half - 1) >> subpixel_bits, tile.y0),
            std::min(((max_x - half) >> subpixel_bits) + 1, tile.x1),
            std::min(((max_y - half) >> subpixel_bits) + 1, tile.y1)};
}

// The corners a, b, c must be clockwise in the picture (positive area); `sign` is +1 where rays leave the
// body, and -1 where they enter it.
void fill(const Corner &a, const Corner &b, const Corner &c, float area, const PixelRect &box,
          std::int32_t sign, const PixelRect &tile, std::int32_t *sums)
{
    const std::int32_t x = box.x0 * subpixels + subpixels / 2, y = box.y0 * subpixels + subpixels / 2;
    Edge ab(a, b, x, y), bc(b, c, x, y), ca(c, a, x, y);
    const DepthPlane plane(a, b, c, area);
    for (std::int32_t row = box.y0; row < box.y1; ++row) {
        std::int64_t first = 0, last = box.x1 - 1 - box.x0;
        for (Edge *edge : {&ab, &bc, &ca}) {
            edge->narrow(first, last);
            edge->row += edge->step_y;
        }
        const std::int32_t at_y = row * subpixels + subpixels / 2;
        const float row_value = plane.origin + plane.slope_y * static_cast<float>(at_y - plane.y);
        std::int32_t *line = sums + (row - tile.y0) * tile_stride + (box.x0 - tile.x0);
        for (std::int64_t column = first; column <= last; ++column)
            line[column] +=
                sign * plane.depth_q10mm(row_value, x + static_cast<std::int32_t>(column) * subpixels);
    }
}

// The picture is seen from the detector, so a face that is turned towards the source is clockwise in the
// picture.
void draw(const Corner &a, const Corner &b, const Corner &c, const PixelRect &tile, std::int32_t *sums)
{
    const PixelRect box = pixels_inside(a, b, c, tile);
    if (box.is_empty()) return;
    const std::int64_t area =
        (static_cast<std::int64_t>(b.x) - a.x) * (static_cast<std::int64_t>(c.y) - a.y) -
        (static_cast<std::int64_t>(b.y) - a.y) * (static_cast<std::int64_t>(c.x) - a.x);
    if (area == 0) return;
    const bool enters = area > 0;
    fill(a, enters ? b : c, enters ? c : b, static_cast<float>(enters ? area : -area), box, enters ? -1 : 1,
         tile, sums);
}

} // namespace

// Cuts the triangle at the near plane, which is 1 mm from the source, and divides the part behind that plane
// into a fan of triangles.
void raster_clipped(const Camera &camera, const std::array<Eigen::Vector3f, 3> &vertices,
                    const PixelRect &tile, std::int32_t *sums)
{
    std::array<Corner, 4> corners;
    int count = 0;
    auto depth = [&](const Eigen::Vector3f &v) { return project_um(camera, v).depth_um; };
    auto cut = [&](const Eigen::Vector3f &inner, const Eigen::Vector3f &outer) {
        const float share = (depth(inner) - near_um) / (depth(inner) - depth(outer));
        const Eigen::Vector3f point = inner + share * (outer - inner);
        Projected p = project_um(camera, point);
        p.depth_um = std::max(p.depth_um, near_um);
        return corner(p);
    };
    for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3f &from = vertices[i], &to = vertices[(i + 1) % 3];
        const bool from_inside = depth(from) >= near_um, to_inside = depth(to) >= near_um;
        if (from_inside) corners[count++] = corner(project_um(camera, from));
        if (from_inside != to_inside) corners[count++] = from_inside ? cut(from, to) : cut(to, from);
    }
    for (int i = 2; i < count; ++i) draw(corners[0], corners[i - 1], corners[i], tile, sums);
}

} // namespace crn
