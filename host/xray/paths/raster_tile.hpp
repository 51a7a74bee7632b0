// Draws the chunks of triangles that touch one tile of the picture. The triangles of the chunks are collected
// in groups of eight, across the borders of chunks.
#pragma once
#include "host/xray/paths/lanes.hpp"
#include "host/xray/paths/raster.hpp"

namespace crn
{

// Holds eight triangles that are processed together, with their edges and depths at the first pixel of each
// triangle's part of the tile.
struct Batch {
    std::int32_t ax[lane_count], ay[lane_count], bx[lane_count], by[lane_count], cx[lane_count],
        cy[lane_count];
    float a_inverse[lane_count], b_inverse[lane_count], c_inverse[lane_count];
    std::int32_t column[lane_count], row[lane_count], columns[lane_count],
        rows[lane_count]; // part of the tile
    // Holds the edge functions at the middle of the first pixel, and their changes from pixel to pixel. The
    // edge functions are divided by `subpixels` and rounded down. The rounding of the edge functions is
    // harmless, because their changes are whole multiples, and only the sign matters.
    std::int32_t edge[3][lane_count], step_x[3][lane_count], step_y[3][lane_count];
    // Holds, for each strip of eight columns, the range of rows that an edge of the triangle allows.
    float from[3][lane_count], from_step[3][lane_count], to[3][lane_count], to_step[3][lane_count];
    float area[lane_count], slope_x[lane_count], slope_y[lane_count], low[lane_count], high[lane_count];
    std::int32_t sign[lane_count];  // -1 for an entry, 0 for an exit
    std::int32_t *sums[lane_count]; // where each is drawn
    // The places of the corners in the texture of trabeculae; all triangles of a group have a texture, or
    // none.
    const RasterVertices::GrainPlace *a_grain[lane_count], *b_grain[lane_count], *c_grain[lane_count];
    std::int32_t is_large = 0; // whether any is large: products need 64 bits
    int count = 0;
};

class TileRaster
{
  public:
    TileRaster(const BodyMeshes &meshes, const RasterVertices &vertices, const Camera &camera,
               const Projection &projection, const PixelRect &tile)
        : meshes_(meshes), vertices_(vertices), camera_(camera), projection_(projection), tile_(tile)
    {
    }

    // Adds to `sums` the part of a chunk of triangles that lies in the tile; the first entry of `sums` is
    // that of pixel (tile.x0, tile.y0).
    void add(std::size_t chunk, std::int32_t *sums);
    // Draws the triangles that have been collected in a group but not yet drawn.
    void finish();

  private:
    template <bool has_grain>
    void add_plain(const MeshChunk &chunk, const Projection::OfChunk &of_chunk, const Corner *corners,
                   std::int32_t *sums);

    const BodyMeshes &meshes_;
    const RasterVertices &vertices_;
    const Camera &camera_;
    const Projection &projection_;
    PixelRect tile_;
    Batch batch_{};
    bool has_grain_ = false; // of the triangles in the group
};

} // namespace crn
