// Draws into one tile: eight triangles are set up together, then each one's rows are drawn eight pixels at a time.
#include "host/xray/lanes.hpp"
#include "host/xray/raster.hpp"
#include <algorithm>

namespace seld
{
namespace
{

constexpr int half = subpixels / 2;

// Eight triangles set up together: edges and depth at the first pixel of each one's part of the tile.
struct Batch {
    std::int32_t ax[lane_count], ay[lane_count], bx[lane_count], by[lane_count], cx[lane_count],
        cy[lane_count];
    float a_inverse[lane_count], b_inverse[lane_count], c_inverse[lane_count];
    std::int32_t column[lane_count], row[lane_count], columns[lane_count],
        rows[lane_count]; // part of the tile
    // Edge functions at the first pixel's centre, and their steps by one pixel; in `subpixels`, rounded down, since the steps
    // are whole multiples and only the sign counts.
    std::int32_t edge[3][lane_count], step_x[3][lane_count], step_y[3][lane_count];
    float area[lane_count], slope_x[lane_count], slope_y[lane_count], low[lane_count], high[lane_count];
    std::int32_t sign[lane_count]; // -1 for an entry, 0 for an exit
    std::int32_t is_large;         // any of them: products need 64 bits
};

namespace plain
{
#include "host/xray/raster_batch.inc"
} // namespace plain

#ifdef SELD_HAS_AVX2
namespace avx2
{
SELD_AVX2_BEGIN
#include "host/xray/raster_batch.inc"
SELD_AVX2_END
} // namespace avx2
#endif

using DrawBatch = void (*)(Batch &batch, int count, const PixelRect &tile, std::int32_t *sums);

DrawBatch choose_draw_batch()
{
#ifdef SELD_HAS_AVX2
    if (__builtin_cpu_supports("avx2")) return avx2::draw_batch;
#endif
    return plain::draw_batch;
}

// Takes one triangle's corners and its part of the tile into place k.
void load(Batch &batch, int k, const Corner &a, const Corner &b, const Corner &c, const KeptTriangle &kept,
          const PixelRect &tile)
{
    batch.ax[k] = a.x, batch.ay[k] = a.y, batch.a_inverse[k] = a.inverse_depth_per_um;
    batch.bx[k] = b.x, batch.by[k] = b.y, batch.b_inverse[k] = b.inverse_depth_per_um;
    batch.cx[k] = c.x, batch.cy[k] = c.y, batch.c_inverse[k] = c.inverse_depth_per_um;
    const int x0 = std::max<int>(kept.x0, tile.x0), y0 = std::max<int>(kept.y0, tile.y0);
    batch.is_large |= kept.is_large;
    batch.column[k] = x0 - tile.x0;
    batch.row[k] = y0 - tile.y0;
    batch.columns[k] = std::min<int>(kept.x1 + 1, tile.x1) - x0;
    batch.rows[k] = std::min<int>(kept.y1 + 1, tile.y1) - y0;
}

void raster_plain(const BodyMeshes &meshes, const MeshChunk &chunk, const Corner *corners,
                  const Projection::OfChunk &of_chunk, const KeptTriangle *kept, const PixelRect &tile,
                  std::int32_t *sums)
{
    const auto *triangles = meshes.triangles.data() + chunk.triangle_begin;
    static const DrawBatch draw_batch = choose_draw_batch();
    Batch batch{};
    int count = 0;
    for (std::uint32_t i = 0; i < of_chunk.kept_count; ++i) {
        const KeptTriangle &triangle = kept[i];
        if (triangle.x0 >= tile.x1 || triangle.x1 < tile.x0 || triangle.y0 >= tile.y1 ||
            triangle.y1 < tile.y0)
            continue;
        const auto [a, b, c] = triangles[triangle.index];
        load(batch, count++, corners[a], corners[b], corners[c], triangle, tile);
        if (count < lane_count) continue;
        draw_batch(batch, count, tile, sums);
        count = 0;
        batch.is_large = 0;
    }
    if (count > 0) draw_batch(batch, count, tile, sums);
}

} // namespace

void raster_tile(const BodyMeshes &meshes, const RasterVertices &vertices, std::size_t index,
                 const Camera &camera, const Projection &projection, const PixelRect &tile,
                 std::int32_t *sums)
{
    const MeshChunk &chunk = meshes.chunks[index];
    const Projection::OfChunk &of_chunk = projection.chunks[index];
    const std::uint32_t begin = vertices.begin[index];
    if (of_chunk.kind == Projection::Kind::plain) {
        raster_plain(meshes, chunk, projection.corners.data() + begin, of_chunk,
                     projection.kept.data() + chunk.triangle_begin, tile, sums);
        return;
    }
    auto vertex = [&](std::uint16_t i) {
        return Eigen::Vector3f(vertices.x_um[begin + i], vertices.y_um[begin + i], vertices.z_um[begin + i]);
    };
    for (std::uint32_t i = 0; i < chunk.triangle_count; ++i) {
        const auto [a, b, c] = meshes.triangles[chunk.triangle_begin + i];
        raster_clipped(camera, {vertex(a), vertex(b), vertex(c)}, tile, sums);
    }
}

} // namespace seld
