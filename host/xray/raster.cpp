// The rasteriser. Corners are snapped to 1/256 pixel; edge functions are integers with the top-left rule, so that
// neighbouring triangles cover every pixel exactly once; depth is perspective-correct (1/depth is a plane).
#include "host/xray/raster.hpp"
#include <algorithm>
#include <cmath>

namespace seld
{
namespace
{

constexpr int subpixel_bits = 8;
constexpr int subpixels = 1 << subpixel_bits;
constexpr float guard_pixels = 8000.0f; // beyond it a chunk takes the wide path
constexpr float near_um = 1000.0f;      // nothing is seen closer to the source than 1 mm
constexpr float q10mm_per_um = 1.024f;

struct Corner {
    std::int32_t x, y; // 1/256 pixel
    float inverse_depth_per_um;
};

// The view in micrometres and single precision.
struct Camera {
    Eigen::Vector3f source, right, up, forward;
    float focal_pixels, half_pixels;
    int size;
};

Camera make_camera(const View &view)
{
    Camera camera;
    camera.source = (view.source_m * 1e6).cast<float>();
    camera.right = view.right.cast<float>();
    camera.up = view.up.cast<float>();
    camera.forward = view.forward.cast<float>();
    camera.focal_pixels = static_cast<float>(view.source_detector_m / view.pixel_m);
    camera.half_pixels = 0.5f * static_cast<float>(view.size);
    camera.size = view.size;
    return camera;
}

float dot(const Eigen::Vector3f &a, float x, float y, float z)
{
    return a.x() * x + a.y() * y + a.z() * z;
}

// Depth and picture position before snapping.
struct Projected {
    float x, y, depth_um;
};

Projected project_um(const Camera &camera, const Eigen::Vector3f &vertex_um)
{
    float x = vertex_um.x() - camera.source.x();
    float y = vertex_um.y() - camera.source.y();
    float z = vertex_um.z() - camera.source.z();
    float depth = dot(camera.forward, x, y, z);
    float scale = camera.focal_pixels / depth;
    return {camera.half_pixels + dot(camera.right, x, y, z) * scale,
            camera.half_pixels - dot(camera.up, x, y, z) * scale, depth};
}

bool is_plain(const Projected &p)
{
    return p.depth_um >= near_um && std::fabs(p.x) <= guard_pixels && std::fabs(p.y) <= guard_pixels;
}

// To nearest, ties up; the offset keeps the truncated value positive.
std::int32_t snap(float pixels)
{
    constexpr float offset = 8192.0f * subpixels;
    return static_cast<std::int32_t>(pixels * subpixels + (offset + 0.5f)) - 8192 * subpixels;
}

// Wide path: up to a million pixels off the picture.
std::int32_t snap_wide(float pixels)
{
    if (std::fabs(pixels) <= guard_pixels) return snap(pixels);
    double held = std::clamp(static_cast<double>(pixels), -1e6, 1e6);
    return static_cast<std::int32_t>(std::floor(held * subpixels + 0.5));
}

// One edge, a to b: positive on the inner side. Value at a pixel centre and its steps by one pixel.
template <class Int> struct Edge {
    Int row, step_x, step_y;

    Edge(const Corner &a, const Corner &b, std::int32_t x, std::int32_t y)
    {
        Int dx = static_cast<Int>(b.x) - a.x, dy = static_cast<Int>(b.y) - a.y;
        bool is_top_left = dy < 0 || (dy == 0 && dx > 0);
        row = dx * (static_cast<Int>(y) - a.y) - dy * (static_cast<Int>(x) - a.x) - (is_top_left ? 0 : 1);
        step_x = -dy * subpixels;
        step_y = dx * subpixels;
    }
    // Narrows [first, last] to the columns on the inner side.
    void narrow(Int &first, Int &last) const
    {
        if (step_x > 0) {
            if (row < 0) first = std::max<Int>(first, (-row + step_x - 1) / step_x);
        } else if (row < 0) {
            last = -1;
        } else if (step_x < 0) {
            last = std::min<Int>(last, row / -step_x);
        }
    }
};

// Plane of 1/depth over the picture, held within the corners' values: a sliver cannot shoot off.
struct DepthPlane {
    float origin, slope_x, slope_y, low, high;
    std::int32_t x, y;

    DepthPlane(const Corner &a, const Corner &b, const Corner &c, float area)
    {
        float ab = b.inverse_depth_per_um - a.inverse_depth_per_um;
        float ac = c.inverse_depth_per_um - a.inverse_depth_per_um;
        float per_area = 1.0f / area;
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

struct PixelBox {
    std::int32_t x0, y0, x1, y1;
};

PixelBox pixels_inside(const Corner &a, const Corner &b, const Corner &c, int size)
{
    constexpr int half = subpixels / 2;
    auto [min_x, max_x] = std::minmax({a.x, b.x, c.x});
    auto [min_y, max_y] = std::minmax({a.y, b.y, c.y});
    return {std::max((min_x + half - 1) >> subpixel_bits, 0),
            std::max((min_y + half - 1) >> subpixel_bits, 0),
            std::min((max_x - half) >> subpixel_bits, size - 1),
            std::min((max_y - half) >> subpixel_bits, size - 1)};
}

// a, b, c clockwise in the picture (positive area); sign is +1 for an exit and -1 for an entry.
template <class Int>
void fill(const Corner &a, const Corner &b, const Corner &c, float area, const PixelBox &box,
          std::int32_t sign, int size, std::int32_t *sums)
{
    const std::int32_t x = box.x0 * subpixels + subpixels / 2, y = box.y0 * subpixels + subpixels / 2;
    Edge<Int> ab(a, b, x, y), bc(b, c, x, y), ca(c, a, x, y);
    const DepthPlane plane(a, b, c, area);
    for (std::int32_t row = box.y0; row <= box.y1; ++row) {
        Int first = 0, last = box.x1 - box.x0;
        ab.narrow(first, last);
        bc.narrow(first, last);
        ca.narrow(first, last);
        const std::int32_t at_y = row * subpixels + subpixels / 2;
        const float row_value = plane.origin + plane.slope_y * static_cast<float>(at_y - plane.y);
        std::int32_t *line = sums + static_cast<std::ptrdiff_t>(row) * size + box.x0;
        for (Int column = first; column <= last; ++column) {
            auto at_x = x + static_cast<std::int32_t>(column) * subpixels;
            line[column] += sign * plane.depth_q10mm(row_value, at_x);
        }
        ab.row += ab.step_y;
        bc.row += bc.step_y;
        ca.row += ca.step_y;
    }
}

// Few columns: testing every pixel is quicker than three divisions per row.
void fill_small(const Corner &a, const Corner &b, const Corner &c, float area, const PixelBox &box,
                std::int32_t sign, int size, std::int32_t *sums)
{
    const std::int32_t x = box.x0 * subpixels + subpixels / 2, y = box.y0 * subpixels + subpixels / 2;
    Edge<std::int32_t> ab(a, b, x, y), bc(b, c, x, y), ca(c, a, x, y);
    const DepthPlane plane(a, b, c, area);
    std::int32_t *line = sums + static_cast<std::ptrdiff_t>(box.y0) * size;
    for (std::int32_t at_y = y; at_y <= box.y1 * subpixels + subpixels / 2; at_y += subpixels) {
        std::int32_t e0 = ab.row, e1 = bc.row, e2 = ca.row;
        const float row_value = plane.origin + plane.slope_y * static_cast<float>(at_y - plane.y);
        for (std::int32_t column = box.x0; column <= box.x1; ++column) {
            if ((e0 | e1 | e2) >= 0)
                line[column] += sign * plane.depth_q10mm(row_value, column * subpixels + subpixels / 2);
            e0 += ab.step_x;
            e1 += bc.step_x;
            e2 += ca.step_x;
        }
        ab.row += ab.step_y;
        bc.row += bc.step_y;
        ca.row += ca.step_y;
        line += size;
    }
}

// The picture is seen from the detector: a face that looks at the source is clockwise in it.
void draw_triangle(const Corner &a, const Corner &b, const Corner &c, int size, std::int32_t *sums)
{
    const PixelBox box = pixels_inside(a, b, c, size);
    if (box.x0 > box.x1 || box.y0 > box.y1) return;
    const std::int64_t area =
        (static_cast<std::int64_t>(b.x) - a.x) * (static_cast<std::int64_t>(c.y) - a.y) -
        (static_cast<std::int64_t>(b.y) - a.y) * (static_cast<std::int64_t>(c.x) - a.x);
    if (area == 0) return;
    const bool enters = area > 0;
    const Corner &second = enters ? b : c, &third = enters ? c : b;
    const float positive_area = static_cast<float>(enters ? area : -area);
    const std::int32_t sign = enters ? -1 : 1;
    auto [min_x, max_x] = std::minmax({a.x, b.x, c.x});
    auto [min_y, max_y] = std::minmax({a.y, b.y, c.y});
    // 64 pixels: products of differences stay below 2^30.
    const bool is_small = max_x - min_x <= 64 * subpixels && max_y - min_y <= 64 * subpixels;
    if (is_small && box.x1 - box.x0 < 8)
        fill_small(a, second, third, positive_area, box, sign, size, sums);
    else if (is_small)
        fill<std::int32_t>(a, second, third, positive_area, box, sign, size, sums);
    else
        fill<std::int64_t>(a, second, third, positive_area, box, sign, size, sums);
}

Corner wide_corner(const Projected &p)
{
    return {snap_wide(p.x), snap_wide(p.y), 1.0f / p.depth_um};
}

// Triangles that reach far off the picture or behind the source: cut at the near plane, then fanned.
void draw_clipped(const Camera &camera, const std::array<Eigen::Vector3f, 3> &vertices, std::int32_t *sums)
{
    std::array<Corner, 4> corners;
    int count = 0;
    auto depth = [&](const Eigen::Vector3f &v) { return project_um(camera, v).depth_um; };
    auto cut = [&](const Eigen::Vector3f &inner, const Eigen::Vector3f &outer) {
        float share = (depth(inner) - near_um) / (depth(inner) - depth(outer));
        Eigen::Vector3f point = inner + share * (outer - inner);
        Projected p = project_um(camera, point);
        p.depth_um = std::max(p.depth_um, near_um);
        return wide_corner(p);
    };
    for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3f &from = vertices[i], &to = vertices[(i + 1) % 3];
        bool from_inside = depth(from) >= near_um, to_inside = depth(to) >= near_um;
        if (from_inside) corners[count++] = wide_corner(project_um(camera, from));
        if (from_inside != to_inside) corners[count++] = from_inside ? cut(from, to) : cut(to, from);
    }
    for (int i = 2; i < count; ++i) draw_triangle(corners[0], corners[i - 1], corners[i], camera.size, sums);
}

// True when the chunk's sphere lies outside one side of the pyramid of rays.
bool is_outside(const Camera &camera, const MeshChunk &chunk)
{
    Eigen::Vector3f centre = chunk.centre_um - camera.source;
    float depth = dot(camera.forward, centre.x(), centre.y(), centre.z());
    if (depth < -chunk.radius_um) return true;
    float half = camera.half_pixels, focal = camera.focal_pixels;
    float slack = chunk.radius_um * std::sqrt(half * half + focal * focal);
    float x = std::fabs(dot(camera.right, centre.x(), centre.y(), centre.z())) * focal;
    float y = std::fabs(dot(camera.up, centre.x(), centre.y(), centre.z())) * focal;
    return x > depth * half + slack || y > depth * half + slack;
}

} // namespace

void raster_chunk(const BodyMeshes &meshes, const MeshChunk &chunk, const View &view, std::int32_t *sums)
{
    const Camera camera = make_camera(view);
    if (is_outside(camera, chunk)) return;
    std::array<Corner, 3 * mesh_chunk_triangles> corners;
    const Eigen::Vector3f *vertices = meshes.vertices_um.data() + chunk.vertex_begin;
    bool all_plain = true;
    for (std::uint32_t i = 0; i < chunk.vertex_count; ++i) {
        Projected p = project_um(camera, vertices[i]);
        if (!is_plain(p)) {
            all_plain = false;
            break;
        }
        corners[i] = {snap(p.x), snap(p.y), 1.0f / p.depth_um};
    }
    const auto *triangles = meshes.triangles.data() + chunk.triangle_begin;
    for (std::uint32_t i = 0; i < chunk.triangle_count; ++i) {
        auto [a, b, c] = triangles[i];
        if (all_plain)
            draw_triangle(corners[a], corners[b], corners[c], camera.size, sums);
        else
            draw_clipped(camera, {vertices[a], vertices[b], vertices[c]}, sums);
    }
}

} // namespace seld
