// Projects triangles to the picture. The corners of triangles are rounded to 1/256 pixel. Edge functions are
// integers and follow the top-left rule, so that neighbouring triangles cover every pixel exactly once. Depth
// has correct perspective, because 1/depth is linear in the picture.
#include "host/xray/paths/raster.hpp"
#include "host/xray/paths/lanes.hpp"
#include <algorithm>
#include <cmath>
#include <cstring>

namespace crn
{
namespace
{

constexpr int half = subpixels / 2;

float dot(const Eigen::Vector3f &a, const Eigen::Vector3f &b)
{
    return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}

// Returns true if the sphere around a chunk of triangles lies outside one side of the pyramid of rays, or
// behind the source.
bool is_outside(const Camera &camera, const MeshChunk &chunk)
{
    const Eigen::Vector3f centre = chunk.centre_um - camera.source;
    const float depth = dot(camera.forward, centre);
    if (depth < -chunk.radius_um) return true;
    const float edge = camera.half_pixels, focal = camera.focal_pixels;
    const float slack = chunk.radius_um * std::sqrt(edge * edge + focal * focal);
    const float x = std::fabs(dot(camera.right, centre)) * focal;
    const float y = std::fabs(dot(camera.up, centre)) * focal;
    return x > depth * edge + slack || y > depth * edge + slack;
}

// Projects whole lanes of corners. Returns false if a corner lies farther from the picture than guard_pixels,
// or nearer to the source than near_um.
CRN_WIDE bool project_corners(const Camera &camera, const float *x_um, const float *y_um, const float *z_um,
                              int count, Corner *corners)
{
    const Eigen::Vector3f source = camera.source, right = camera.right, up = camera.up,
                          forward = camera.forward;
    const float focal = camera.focal_pixels, middle = camera.half_pixels;
    std::int32_t is_far = 0;
    for (int begin = 0; begin < count; begin += lane_count) {
        std::int32_t at_x[lane_count], at_y[lane_count];
        float inverse[lane_count];
        for (int i = 0; i < lane_count; ++i) {
            const float x = x_um[begin + i] - source.x(), y = y_um[begin + i] - source.y(),
                        z = z_um[begin + i] - source.z();
            const float depth = forward.x() * x + forward.y() * y + forward.z() * z;
            const float scale = focal / depth;
            const float u = middle + (right.x() * x + right.y() * y + right.z() * z) * scale;
            const float v = middle - (up.x() * x + up.y() * y + up.z() * z) * scale;
            const bool is_plain =
                int{depth >= near_um} & int{std::fabs(u) <= guard_pixels} & int{std::fabs(v) <= guard_pixels};
            is_far |= is_plain ? 0 : 1;
            // The projected coordinate is limited, because converting a number to an integer is undefined if
            // the number is too large. A chunk of triangles with a corner beyond guard_pixels is drawn by
            // raster_clipped instead.
            const float held_u = u < guard_pixels ? (u > -guard_pixels ? u : -guard_pixels) : guard_pixels;
            const float held_v = v < guard_pixels ? (v > -guard_pixels ? v : -guard_pixels) : guard_pixels;
            at_x[i] = snap(held_u);
            at_y[i] = snap(held_v);
            inverse[i] = 1.0f / depth;
        }
        for (int i = 0; i < lane_count; ++i) corners[begin + i] = {at_x[i], at_y[i], inverse[i]};
    }
    return is_far == 0;
}

// Reads the four numbers of a corner: x, y, the bits of 1/depth, and 0.
inline __attribute__((always_inline)) void read_numbers(const Corner &corner, Four_i &numbers)
{
    static_assert(sizeof(Corner) == sizeof(Four_i));
    numbers = *reinterpret_cast<const Four_i_anywhere *>(&corner.x);
}

// Keeps the triangles whose bounding box contains the middle of a pixel in `rect`, together with those
// pixels, and leaves out all others. Of the four numbers of a corner, the first two count.
CRN_WIDE void keep_triangles(const std::array<std::uint16_t, 3> *triangles, std::uint32_t count,
                             const Corner *corners, const PixelRect &rect, KeptTriangle *kept,
                             Projection::OfChunk &of_chunk)
{
    constexpr int large = 64 * subpixels; // from here on, products of differences pass 2^30
    const Four_i first = {rect.x0, rect.y0, 0, 0}, last = {rect.x1 - 1, rect.y1 - 1, 0, 0};
    Four_i least = {INT16_MAX, INT16_MAX, 0, 0}, greatest = {-1, -1, 0, 0};
    std::uint32_t kept_count = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto [first_corner, second_corner, third_corner] = triangles[i];
        Four_i a, b, c;
        read_numbers(corners[first_corner], a);
        read_numbers(corners[second_corner], b);
        read_numbers(corners[third_corner], c);
        Four_i low = a < b ? a : b, high = a > b ? a : b;
        low = low < c ? low : c;
        high = high > c ? high : c;
        Four_i from = (low + (half - 1)) >> subpixel_bits, to = (high - half) >> subpixel_bits;
        from = from > first ? from : first;
        to = to < last ? to : last;
        if (from[0] > to[0] || from[1] > to[1]) continue;
        const Four_i wide = high - low;
        kept[kept_count++] = {static_cast<std::int16_t>(from[0]),
                              static_cast<std::int16_t>(from[1]),
                              static_cast<std::int16_t>(to[0]),
                              static_cast<std::int16_t>(to[1]),
                              {first_corner, second_corner, third_corner},
                              static_cast<std::uint16_t>(wide[0] > large || wide[1] > large)};
        least = least < from ? least : from;
        greatest = greatest > to ? greatest : to;
    }
    of_chunk = {Projection::Kind::plain,
                static_cast<std::int16_t>(least[0]),
                static_cast<std::int16_t>(least[1]),
                static_cast<std::int16_t>(greatest[0]),
                static_cast<std::int16_t>(greatest[1]),
                kept_count};
}

// Copies the chosen points of a list of x y z to one array per coordinate.
CRN_WIDE void gather(const int *points, const std::uint32_t *chosen, std::uint32_t count, float *x, float *y,
                     float *z)
{
    for (std::uint32_t k = 0; k < count; ++k) {
        const int *point = points + 3 * static_cast<std::size_t>(chosen[k]);
        x[k] = static_cast<float>(point[0]);
        y[k] = static_cast<float>(point[1]);
        z[k] = static_cast<float>(point[2]);
    }
}

struct Extent {
    float low, high;
};

// Returns the least and the greatest of `count` values; the array is filled up to whole lanes.
CRN_WIDE Extent extent(const float *values, std::uint32_t count)
{
    Lanes_f low, high;
    std::memcpy(&low, values, sizeof low);
    high = low;
    for (std::uint32_t k = lane_count; k < count; k += lane_count) {
        Lanes_f value;
        std::memcpy(&value, values + k, sizeof value);
        low = value < low ? value : low;
        high = value > high ? value : high;
    }
    Extent all = {low[0], high[0]};
    for (int i = 1; i < lane_count; ++i) {
        all.low = std::min(all.low, low[i]);
        all.high = std::max(all.high, high[i]);
    }
    return all;
}

} // namespace

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

RasterVertices::RasterVertices(const BodyMeshes &meshes)
{
    std::size_t count = 0;
    for (const MeshChunk &chunk : meshes.chunks) {
        begin.push_back(static_cast<std::uint32_t>(count));
        count += (chunk.vertex_count + lane_count - 1) / lane_count * lane_count;
    }
    for (auto *coordinate : {&x_um, &y_um, &z_um}) coordinate->resize(count);
    for (std::size_t i = 0; i < meshes.chunks.size(); ++i) {
        const MeshChunk &chunk = meshes.chunks[i];
        for (std::uint32_t k = 0; k < chunk.vertex_count; ++k) {
            const Eigen::Vector3f &vertex_um = meshes.vertices_um[chunk.vertex_begin + k];
            x_um[begin[i] + k] = vertex_um.x();
            y_um[begin[i] + k] = vertex_um.y();
            z_um[begin[i] + k] = vertex_um.z();
        }
        fill(chunk, begin[i]);
    }
    for (const Eigen::Vector3f &place : meshes.grain_places) {
        GrainPlace fixed = {};
        for (int axis = 0; axis < 3; ++axis)
            fixed.of[axis] = static_cast<std::uint32_t>(static_cast<std::int64_t>(
                std::floor(double{place[axis]} * (1 << grain_fraction_bits) + 0.5)));
        grain_places.push_back(fixed);
    }
}

void RasterVertices::fill(const MeshChunk &chunk, std::uint32_t at)
{
    const std::uint32_t last = at + chunk.vertex_count - 1;
    for (std::uint32_t k = last + 1; (k - at) % lane_count != 0; ++k) {
        x_um[k] = x_um[last];
        y_um[k] = y_um[last];
        z_um[k] = z_um[last];
    }
}

void RasterVertices::move(BodyMeshes &meshes, std::size_t index, std::span<const Eigen::Vector3i> vertices_um)
{
    MeshChunk &chunk = meshes.chunks[index];
    const std::uint32_t at = begin[index];
    float *x = x_um.data() + at, *y = y_um.data() + at, *z = z_um.data() + at;
    gather(vertices_um.data()->data(), meshes.body_vertex.data() + chunk.vertex_begin, chunk.vertex_count, x,
           y, z);
    fill(chunk, at);
    const Extent along_x = extent(x, chunk.vertex_count), along_y = extent(y, chunk.vertex_count),
                 along_z = extent(z, chunk.vertex_count);
    set_sphere(chunk, {along_x.low, along_y.low, along_z.low}, {along_x.high, along_y.high, along_z.high});
}

void project_chunk(const BodyMeshes &meshes, const RasterVertices &vertices, std::size_t index,
                   const Camera &camera, const PixelRect &rect, Projection &projection)
{
    const MeshChunk &chunk = meshes.chunks[index];
    Projection::OfChunk &of_chunk = projection.chunks[index];
    of_chunk = {};
    if (is_outside(camera, chunk)) return;
    const std::uint32_t begin = vertices.begin[index];
    Corner *corners = projection.corners.data() + begin;
    if (project_corners(camera, vertices.x_um.data() + begin, vertices.y_um.data() + begin,
                        vertices.z_um.data() + begin, static_cast<int>(chunk.vertex_count), corners))
        keep_triangles(meshes.triangles.data() + chunk.triangle_begin, chunk.triangle_count, corners, rect,
                       projection.kept.data() + chunk.triangle_begin, of_chunk);
    else
        of_chunk = {Projection::Kind::clipped,
                    static_cast<std::int16_t>(rect.x0),
                    static_cast<std::int16_t>(rect.y0),
                    static_cast<std::int16_t>(rect.x1 - 1),
                    static_cast<std::int16_t>(rect.y1 - 1),
                    0};
}

} // namespace crn
