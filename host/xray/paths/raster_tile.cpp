// Draws triangles into one tile. The edges and depths of eight triangles are computed together, and then the
// rows of each triangle are drawn eight pixels at a time.
#include "host/xray/paths/raster_tile.hpp"
#include <algorithm>
#include <cmath>
#include <cstring>
#ifdef CRN_HAS_AVX2
#include <immintrin.h>
#endif

namespace crn
{
namespace
{

constexpr int half = subpixels / 2;
constexpr int strips_max = tile_columns / lane_count;

namespace plain
{

inline void read_cells(const std::int8_t *block, const Lanes_u &index, Lanes_i &cells)
{
    for (int i = 0; i < lane_count; ++i) cells[i] = block[index[i]];
}

#include "host/xray/paths/raster_batch.inc"
#include "host/xray/paths/raster_grain.inc"
} // namespace plain

#ifdef CRN_HAS_AVX2
namespace avx2
{
CRN_AVX2_BEGIN

// Reads four bytes that end with the cell, and keeps the last one.
inline void read_cells(const std::int8_t *block, const Lanes_u &index, Lanes_i &cells)
{
    const auto *last = reinterpret_cast<const int *>(block - 3);
    cells = (Lanes_i)_mm256_i32gather_epi32(last, (__m256i)index, 1) >> 24;
}

#include "host/xray/paths/raster_batch.inc"
#include "host/xray/paths/raster_grain.inc"
CRN_AVX2_END
} // namespace avx2
#endif

// The inner loops for this processor.
struct Loops {
    void (*draw_batch)(Batch &batch, const PixelRect &tile);
    void (*draw_grainy_batch)(Batch &batch, const Grain &grain, const PixelRect &tile);
};

Loops choose_loops()
{
#ifdef CRN_HAS_AVX2
    if (__builtin_cpu_supports("avx2")) return {avx2::draw_batch, avx2::draw_grainy_batch};
#endif
    return {plain::draw_batch, plain::draw_grainy_batch};
}

// Tests whether a triangle lies outside a tile, with one subtraction for all four sides: the pixels of a
// triangle are four numbers of 15 bits, and a number that passes its limit takes the bit above its own.
class TileBounds
{
  public:
    explicit TileBounds(const PixelRect &tile)
        : limits_(packed(tile.x1 - 1, tile.y1 - 1, most - tile.x0, most - tile.y0) | tops)
    {
    }
    bool leave_out(const KeptTriangle &triangle) const
    {
        std::uint64_t pixels;
        std::memcpy(&pixels, &triangle, sizeof pixels);
        return (~(limits_ - (pixels ^ mirrored_)) & tops) != 0;
    }

  private:
    static constexpr int most = 0x7fff;
    static constexpr std::uint64_t tops = 0x8000800080008000u;
    static std::uint64_t packed(int x0, int y0, int x1, int y1)
    {
        const std::int16_t four[4] = {static_cast<std::int16_t>(x0), static_cast<std::int16_t>(y0),
                                      static_cast<std::int16_t>(x1), static_cast<std::int16_t>(y1)};
        std::uint64_t bits;
        std::memcpy(&bits, four, sizeof bits);
        return bits;
    }
    std::uint64_t limits_,
        mirrored_ = packed(0, 0, most, most); // the last pixels count from `most` downwards
};

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
    static const Loops loops = choose_loops();
    if (batch_.count == 0) return;
    // The unused entries of the group are set to 0, because old values of an earlier triangle could make
    // 32-bit numbers overflow.
    for (int k = batch_.count; k < lane_count; ++k)
        batch_.ax[k] = batch_.ay[k] = batch_.bx[k] = batch_.by[k] = batch_.cx[k] = batch_.cy[k] = 0;
    if (has_grain_)
        loops.draw_grainy_batch(batch_, projection_.grain, tile_);
    else
        loops.draw_batch(batch_, tile_);
    batch_.count = 0;
    batch_.is_large = 0;
}

template <bool has_grain>
void TileRaster::add_plain(const MeshChunk &chunk, const Projection::OfChunk &of_chunk, const Corner *corners,
                           std::int32_t *sums)
{
    const KeptTriangle *kept = projection_.kept.data() + chunk.triangle_begin;
    const RasterVertices::GrainPlace *places =
        has_grain ? vertices_.grain_places.data() + *chunk.grain_begin : nullptr;
    const PixelRect tile = tile_;
    const TileBounds bounds(tile);
    for (std::uint32_t i = 0; i < of_chunk.kept_count; ++i) {
        const KeptTriangle &triangle = kept[i];
        if (bounds.leave_out(triangle)) continue;
        const auto [a, b, c] = triangle.corner;
        batch_.sums[batch_.count] = sums;
        if constexpr (has_grain) {
            batch_.a_grain[batch_.count] = places + a;
            batch_.b_grain[batch_.count] = places + b;
            batch_.c_grain[batch_.count] = places + c;
        }
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
        const Corner *corners = projection_.corners.data() + begin;
        const bool has_grain = chunk.grain_begin.has_value();
        if (has_grain != has_grain_) finish();
        has_grain_ = has_grain;
        if (has_grain)
            add_plain<true>(chunk, of_chunk, corners, sums);
        else
            add_plain<false>(chunk, of_chunk, corners, sums);
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
