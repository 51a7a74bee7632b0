// Draws triangles into one tile. The edges and depths of eight triangles are computed together, and then the
// rows of each triangle are drawn eight pixels at a time.
#include "host/xray/paths/raster_tile.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

constexpr int half = subpixels / 2;
constexpr int strips_max = tile_columns / lane_count;

namespace plain
{
#include "host/xray/paths/raster_batch.inc"
} // namespace plain

#ifdef CRN_HAS_AVX2
namespace avx2
{
CRN_AVX2_BEGIN
#include "host/xray/paths/raster_batch.inc"
CRN_AVX2_END
} // namespace avx2
#endif

using DrawBatch = void (*)(Batch &batch, const PixelRect &tile);

DrawBatch choose_draw_batch()
{
#ifdef CRN_HAS_AVX2
    if (__builtin_cpu_supports("avx2")) return avx2::draw_batch;
#endif
    return plain::draw_batch;
}

// Copies the corners of one triangle, and the part of the tile that it can cover, to entry k of the group of
// eight triangles.
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

} // namespace

void TileRaster::finish()
{
    static const DrawBatch draw_batch = choose_draw_batch();
    if (batch_.count == 0) return;
    // The unused entries of the group are set to 0, because old values of an earlier triangle could make
    // 32-bit numbers overflow.
    for (int k = batch_.count; k < lane_count; ++k)
        batch_.ax[k] = batch_.ay[k] = batch_.bx[k] = batch_.by[k] = batch_.cx[k] = batch_.cy[k] = 0;
    draw_batch(batch_, tile_);
    batch_.count = 0;
    batch_.is_large = 0;
}

void TileRaster::add_plain(const MeshChunk &chunk, const Projection::OfChunk &of_chunk, const Corner *corners,
                           std::int32_t *sums)
{
    const KeptTriangle *kept = projection_.kept.data() + chunk.triangle_begin;
    const PixelRect tile = tile_;
    const bool is_inside =
        of_chunk.x0 >= tile.x0 && of_chunk.x1 < tile.x1 && of_chunk.y0 >= tile.y0 && of_chunk.y1 < tile.y1;
    for (std::uint32_t i = 0; i < of_chunk.kept_count; ++i) {
        const KeptTriangle &triangle = kept[i];
        if (!is_inside && (triangle.x0 >= tile.x1 || triangle.x1 < tile.x0 || triangle.y0 >= tile.y1 ||
                           triangle.y1 < tile.y0))
            continue;
        const auto [a, b, c] = triangle.corner;
        batch_.sums[batch_.count] = sums;
        load(batch_, batch_.count++, corners[a], corners[b], corners[c], triangle, tile);
        if (batch_.count == lane_count) finish();
    }
}

void TileRaster::add(std::size_t index, std::int32_t *sums)
{
    const MeshChunk &chunk = meshes_.chunks[index];
    const Projection::OfChunk &of_chunk = projection_.chunks[index];
    const std::uint32_t begin = vertices_.begin[index];
    if (of_chunk.kind == Projection::Kind::plain) {
        add_plain(chunk, of_chunk, projection_.corners.data() + begin, sums);
        return;
    }
    auto vertex = [&](std::uint16_t i) {
        return Eigen::Vector3f(vertices_.x_um[begin + i], vertices_.y_um[begin + i],
                               vertices_.z_um[begin + i]);
    };
    for (std::uint32_t i = 0; i < chunk.triangle_count; ++i) {
        const auto [a, b, c] = meshes_.triangles[chunk.triangle_begin + i];
        raster_clipped(camera_, {vertex(a), vertex(b), vertex(c)}, tile_, sums);
    }
}

} // namespace crn
