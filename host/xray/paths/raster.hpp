// Depth sums of closed meshes: where a ray leaves a body its distance is added, where it enters it is
// subtracted. The sums are int32 in 1/1024 mm along the central axis, so their total does not depend on the
// order of triangles.
//
// A picture is drawn in two passes, each shared out among threads. project_chunk projects every chunk's
// corners onto the picture and keeps the triangles that cover a pixel's centre. TileRaster draws the
// triangles that meet one tile into sums that stay in the processor's cache.
#pragma once
#include "host/xray/paths/paths.hpp"

namespace crn
{

inline constexpr int subpixel_bits = 8;
inline constexpr int subpixels = 1 << subpixel_bits;

// The view in micrometres and single precision.
struct Camera {
    Eigen::Vector3f source, right, up, forward;
    float focal_pixels, half_pixels;
    int size;
};
Camera make_camera(const View &view);

// A place on the picture, in 1/subpixels of a pixel.
struct alignas(16) Corner {
    std::int32_t x, y;
    float inverse_depth_per_um;
    std::int32_t unused = 0;
};

inline constexpr float near_um = 1000.0f;      // nothing closer to the source than 1 mm is drawn
inline constexpr float guard_pixels = 8000.0f; // beyond it a chunk takes the slow path
inline constexpr float q10mm_per_um = 1.024f;

// Rounds to nearest, ties up, within the guard; the offset keeps the truncated value positive.
inline std::int32_t snap(float pixels)
{
    constexpr float offset = 8192.0f * subpixels;
    return static_cast<std::int32_t>(pixels * subpixels + (offset + 0.5f)) - 8192 * subpixels;
}

// The pixels x0 .. x1, y0 .. y1, both included, inside the box of a triangle.
struct KeptTriangle {
    std::int16_t x0, y0, x1, y1;
    std::uint16_t corner[3]; // index in the chunk
    std::uint16_t is_large;  // more than 64 pixels wide or high: products of differences may pass 2^31
};

// The corners are stored by coordinate, separately for each chunk and padded to whole lanes.
struct RasterVertices {
    std::vector<float> x_um, y_um, z_um;
    std::vector<std::uint32_t> begin; // of each chunk

    explicit RasterVertices(const BodyMeshes &meshes);
    void set(const BodyMeshes &meshes, std::size_t chunk); // reads that chunk's vertices again
};

// The projection of all chunks in one frame.
struct Projection {
    enum class Kind : std::uint8_t { nowhere, plain, clipped };
    struct OfChunk {
        Kind kind = Kind::nowhere;
        std::int16_t x0 = 0, y0 = 0, x1 = 0, y1 = 0; // pixels, both ends included
        std::uint32_t kept_count = 0;
    };
    std::vector<OfChunk> chunks;
    std::vector<std::uint32_t> seen; // the chunks that lie in the picture
    std::vector<Corner> corners;     // in the order of RasterVertices
    std::vector<KeptTriangle> kept;  // starting at the chunk's triangle_begin
};

// Fills the projection of chunk `index`; it keeps only what can appear in `rect`.
void project_chunk(const BodyMeshes &meshes, const RasterVertices &vertices, std::size_t index,
                   const Camera &camera, const PixelRect &rect, Projection &projection);

// A tile's sums, one picture per channel; the columns beyond its width take what the lanes write past the
// edge.
inline constexpr int tile_columns = 128, tile_rows = 64;
inline constexpr int tile_stride = tile_columns + 8;
inline constexpr int tile_ints = tile_rows * tile_stride;

// The slow path, for triangles that reach far off the picture or behind the source.
void raster_clipped(const Camera &camera, const std::array<Eigen::Vector3f, 3> &vertices_um,
                    const PixelRect &tile, std::int32_t *sums);

} // namespace crn
