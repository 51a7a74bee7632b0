// Computes depth sums of closed meshes: the depth where a ray leaves a body is added, and the depth where it
// enters is subtracted. The depth sums are int32 in 1/1024 mm along the central axis, so they do not depend
// on the order of the triangles.
//
// A picture is drawn in two passes, and several threads share the work of each pass. In the first pass
// project_chunk projects the corners of every chunk to the picture, and keeps the triangles that cover the
// middle of a pixel. In the second pass TileRaster draws all triangles that touch one tile of the picture;
// their depths are added to sums that stay in the processor's cache.
#pragma once
#include "host/xray/paths/lanes.hpp"
#include "host/xray/paths/paths.hpp"
#include "host/xray/paths/trabeculae.hpp"

namespace crn
{

inline constexpr int subpixel_bits = 8;
inline constexpr int subpixels = 1 << subpixel_bits;

// Describes the view in micrometres and single precision.
struct Camera {
    Eigen::Vector3f source, right, up, forward;
    float focal_pixels, half_pixels;
    int size;
};
Camera make_camera(const View &view);

// Describes a position in the picture, in units of 1/subpixels of a pixel.
struct alignas(16) Corner {
    std::int32_t x, y;
    float inverse_depth_per_um;
    std::int32_t unused = 0;
};

inline constexpr float near_um = 1000.0f;      // nothing closer to the source than 1 mm is drawn
inline constexpr float guard_pixels = 8000.0f; // beyond it a chunk takes the slow path
inline constexpr float q10mm_per_um = 1.024f;

// Rounds a position within guard_pixels to the nearest integer (halves upwards); an offset keeps the number
// positive, so that truncation rounds down.
inline std::int32_t snap(float pixels)
{
    constexpr float offset = 8192.0f * subpixels;
    return static_cast<std::int32_t>(pixels * subpixels + (offset + 0.5f)) - 8192 * subpixels;
}

// Holds the pixels x0 .. x1, y0 .. y1 inside the bounding box of a triangle; both ends are included.
struct KeptTriangle {
    std::int16_t x0, y0, x1, y1;
    std::uint16_t corner[3]; // index in the chunk
    std::uint16_t is_large;  // more than 64 pixels wide or high: products of differences may pass 2^31
};

inline constexpr int grain_fraction_bits = 22; // edges of triangles may cross 512 cells

// The coordinates of the corners are stored in separate arrays for x, y and z. The number of stored corners
// of each chunk is a multiple of eight; the last corner of the chunk fills the unused entries.
struct RasterVertices {
    std::vector<float> x_um, y_um, z_um;
    std::vector<std::uint32_t> begin; // of each chunk
    // The places of BodyMeshes::grain_places, in 1/2^grain_fraction_bits of a cell. A place wraps around
    // after 2^32, which is a whole number of periods of the texture.
    struct GrainPlace {
        Four_u of; // u, v, w, 0
    };
    std::vector<GrainPlace> grain_places;

    explicit RasterVertices(const BodyMeshes &meshes);
    // Moves the vertices of one chunk, and the sphere around it, to the new positions in the vertex list of
    // the chunk's body. meshes.vertices_um stays unchanged.
    void move(BodyMeshes &meshes, std::size_t chunk, std::span<const Eigen::Vector3i> vertices_um);

  private:
    // Copies a chunk's last vertex to the unused entries after it.
    void fill(const MeshChunk &chunk, std::uint32_t at);
};

// Holds the projections of all chunks of triangles in one frame.
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
    Grain grain;                     // if the bodies have a texture
};

// Computes the projection of chunk `index`, and keeps only those of its triangles that can appear in `rect`.
void project_chunk(const BodyMeshes &meshes, const RasterVertices &vertices, std::size_t index,
                   const Camera &camera, const PixelRect &rect, Projection &projection);

// A tile, which is a small rectangle of the picture, has one picture of depth sums per channel. Each row of a
// tile has extra columns, because groups of eight pixels are written past the tile's edge.
inline constexpr int tile_columns = 128, tile_rows = 64;
inline constexpr int tile_stride = tile_columns + 8;
inline constexpr int tile_ints = tile_rows * tile_stride;

// Draws triangles that reach far outside the picture or behind the source; this function is slower than
// TileRaster.
void raster_clipped(const Camera &camera, const std::array<Eigen::Vector3f, 3> &vertices_um,
                    const PixelRect &tile, std::int32_t *sums);

} // namespace crn
