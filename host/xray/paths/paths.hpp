// A path length is the length over which a ray crosses a material; each ray has one path length for each
// material. All later steps, beginning with the transmission (host/xray/chain.hpp), use only path lengths,
// and do not depend on meshes and tubes.
//
//     Bodies ──> BodyPaths (a back end: RasterPaths, or OpenGL) ──┐
//                                                                 ├──> PathKeeper ──> chain
//     tools on the wire, by exact chords (tube.hpp) ──────────────┘
//
// A back end, which computes path lengths, must deliver one int32 for each material and pixel (see
// BodyPaths::draw), in units of 1/1024 mm. The number for a pixel belongs to the ray through its middle: the
// sum, over all faces of the selected bodies, of (depth where the ray leaves a body) - (depth where it enters
// the body). The sum of a body is added to the path length in the body's own material, and subtracted from
// that in the parent's (surrounding) material. Bodies may be nested to any depth and need no sorting.
// RasterPaths is the reference. The results of another back end may differ from those of RasterPaths by
// rounding, and a test limits this difference.
#pragma once
#include "host/xray/paths/carm.hpp"
#include "host/xray/paths/materials.hpp"
#include "host/xray/paths/meshes.hpp"
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace crn
{

// Holds one picture of path lengths per material, size*size pixels with row 0 on top, in 1/1024 mm. The
// picture of a material is empty if the scene has no such material.
using PathPictures = std::array<std::vector<std::int32_t>, material_count>;

// Describes the pixels in columns [x0, x1) and rows [y0, y1).
struct PixelRect {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    bool is_empty() const { return x0 >= x1 || y0 >= y1; }
};

enum class PathForm {
    axis_sums,   // along the central axis (depth), signed: other sums may be added
    ray_lengths, // final lengths along the ray, none below 0
};

// A back end computes the path lengths through closed bodies. A back end is made for one BodyMeshes, which
// must exist longer than the back end. Only one thread at a time may use a back end.
class BodyPaths
{
  public:
    virtual ~BodyPaths() = default;
    virtual std::string_view name() const = 0; // for messages and file headers: "raster", "opengl"

    // Replaces the vertices of one body, for all later pictures, by the same number of new vertices.
    virtual void move(int body, std::span<const Eigen::Vector3i> vertices_um) = 0;

    // Sets every pixel in `rect` to the sum of depths of the bodies whose entry in `is_drawn` is not 0; the
    // list has one entry per body. The depth sums are set in the pictures of all materials that the channels
    // of the meshes use. Pixels outside `rect` do not change. `pictures` must already have the right sizes.
    // Those parts of bodies that lie behind the source, or nearer to the source than 1 mm, are not drawn.
    // Returns false with a message if the graphics device fails; PathKeeper then continues with RasterPaths.
    virtual bool draw(const View &view, std::span<const std::uint8_t> is_drawn, const PixelRect &rect,
                      PathForm form, PathPictures &pictures, std::string &error) = 0;

    // Sets the pixels in `rect` to the ray lengths of the selected bodies together with the bodies whose
    // depth sums draw() has written to `still`. If `is_new` is false, then `pictures` hold the result of the
    // last call with the same view, the same sums and the same selection, and `rect` contains all pixels that
    // the selected bodies cover now or covered at that call; the back end may keep every pixel whose ray they
    // do not meet.
    virtual bool draw_on(const PathPictures &still, bool is_new, const View &view,
                         std::span<const std::uint8_t> is_drawn, const PixelRect &rect,
                         PathPictures &pictures, std::string &error) = 0;
};

// Converts depth sums along the central axis to path lengths along the rays, in place, for the columns
// [begin, end) of one row.
void finish_row(const View &view, int row, int begin, int end, std::int32_t *line);

// Computes for each pixel [begin, end) of a row the length along its ray divided by the length along the
// central axis.
void oblique_of_row(const View &view, int row, int begin, int end, float *oblique);

// Holds the path lengths in tools, which are added to the path lengths in the bodies. Only the pixels that a
// tool touches have an entry with path lengths in tools. Several rays pass through each pixel that a tool
// touches, because tools are thin. Inside a wide tube, all rays of a pixel have nearly the same path length,
// so a wide tube has one path length for all rays of a pixel.
inline constexpr int tool_rays = 9;

struct ToolPaths {
    int size = 0;
    std::vector<Material> materials;  // drawn in this frame
    std::vector<std::int32_t> pixels; // touched, row*size + column, each once, in rising order
    std::vector<std::int32_t>
        entry; // of each pixel of the picture: the index of its path lengths, -1 for none
    // The path lengths are in 1/1024 mm; a negative length is subtracted (blood that metal displaces). The
    // length of a ray is the sum of its own length in narrow tubes and of the pixel's length in wide tubes.
    std::vector<std::int32_t> wide_q10mm;   // [entry][material], the same for all rays
    std::vector<std::int32_t> narrow_entry; // of each entry: its index in narrow_q10mm, -1 for none
    std::vector<std::int32_t> narrow_q10mm; // [narrow entry][material][ray]

    // Path length of undiluted contrast medium in vessels finer than a pixel and in tissue, mm, of each
    // pixel; empty: none. It is short everywhere, and is no part of the entries.
    std::vector<float> haze_mm;

    // Working data of the painter: all touched pixels of a row are in these columns.
    struct Columns {
        int begin, end;
    };
    std::vector<Columns> touched;

    // Returns the path lengths [material] in wide tubes.
    const std::int32_t *wide(std::int32_t entry_of_pixel) const
    {
        return wide_q10mm.data() + static_cast<std::size_t>(entry_of_pixel) * materials.size();
    }
    // Returns the path lengths [material][ray] in narrow tubes, or nullptr if no narrow tube touches the
    // pixel.
    const std::int32_t *narrow(std::int32_t entry_of_pixel) const
    {
        const std::int32_t place = narrow_entry[static_cast<std::size_t>(entry_of_pixel)];
        if (place < 0) return nullptr;
        return narrow_q10mm.data() + static_cast<std::size_t>(place) * materials.size() * tool_rays;
    }
    // Returns the sum of path lengths over all rays of one pixel, for one of `materials`; this sum is
    // tool_rays times the mean.
    std::int32_t sum(std::int32_t pixel, std::size_t material) const
    {
        const std::int32_t at = entry[static_cast<std::size_t>(pixel)];
        if (at < 0) return 0;
        std::int32_t sum = tool_rays * wide(at)[material];
        if (const std::int32_t *rays = narrow(at))
            for (int k = 0; k < tool_rays; ++k) sum += rays[material * tool_rays + k];
        return sum;
    }
};

} // namespace crn
