// Path lengths: the length of each material that every ray crosses. Everything from photons on
// (host/xray/chain.hpp) uses only these lengths and is independent of meshes and tubes.
//
//     Bodies ──> BodyPaths (a back end: RasterPaths, or OpenGL) ──┐
//                                                                 ├──> PathKeeper ──> chain
//     tools on the wire, by exact chords (tube.hpp) ──────────────┘
//
// A back end must deliver one int32 for each material and pixel (see BodyPaths::draw). Its unit is 1/1024 mm.
// Its value is (depth where the ray leaves) - (depth where it enters) along the ray through the pixel's
// centre, summed over all faces of the selected bodies. A body's sum is added to its own material and
// subtracted from its parent's, whatever lies between, so that bodies nested to any depth need no sorting.
// RasterPaths is the reference. Another back end may differ by rounding, and a test checks that it stays
// within a stated distance of RasterPaths.
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

// One picture per material, size*size, row 0 on top, in 1/1024 mm; empty where the scene has no such
// material.
using PathPictures = std::array<std::vector<std::int32_t>, material_count>;

// Pixels [x0, x1) x [y0, y1).
struct PixelRect {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    bool is_empty() const { return x0 >= x1 || y0 >= y1; }
};

enum class PathForm {
    axis_sums,   // along the central axis (depth), signed: other sums may be added
    ray_lengths, // final lengths along the ray, none below 0
};

// A back end that draws closed bodies. It is made for one BodyMeshes, which outlives it; only one thread uses
// it at a time.
class BodyPaths
{
  public:
    virtual ~BodyPaths() = default;
    virtual std::string_view name() const = 0; // for messages and file headers: "raster", "opengl"

    // Replaces the vertices of one body by equally many others from now on.
    virtual void move(int body, std::span<const Eigen::Vector3i> vertices_um) = 0;

    // Sets every pixel of `rect` to the sums of the bodies whose `is_drawn` is not 0 (one entry per body). It
    // does so in the pictures of all materials that the meshes' channels name; the rest of each picture
    // stays. `pictures` has the right sizes already. Nothing nearer to the source than 1 mm, or behind it, is
    // drawn. Returns false with a message when the device fails; PathKeeper then continues with RasterPaths.
    virtual bool draw(const View &view, std::span<const std::uint8_t> is_drawn, const PixelRect &rect,
                      PathForm form, PathPictures &pictures, std::string &error) = 0;
};

// Turns axis sums into ray lengths in place: columns [begin, end) of one row.
void finish_row(const View &view, int row, int begin, int end, std::int32_t *line);

// The path lengths that tools add to the bodies'. Only pixels that a tool touches have entries. Several rays
// cross each pixel, since tools are thin; each ray has one length per drawn material.
inline constexpr int tool_rays = 9;

struct ToolPaths {
    int size = 0;
    std::vector<Material> materials;  // drawn in this frame
    std::vector<std::int32_t> pixels; // touched, row*size + column, each once, in drawing order
    std::vector<std::int32_t> entry;  // of each pixel of the picture: its index in `pixels`, -1 for none
    // [touched pixel][material][ray], 1/1024 mm; a negative length is subtracted (blood that metal
    // displaces).
    std::vector<std::int32_t> q10mm;

    std::size_t ints_per_pixel() const { return materials.size() * tool_rays; }
    // Returns the sum over all rays of one touched pixel for one of `materials`: tool_rays times the mean.
    std::int32_t sum(std::size_t touched, std::size_t material) const
    {
        const std::int32_t *ray = q10mm.data() + touched * ints_per_pixel() + material * tool_rays;
        std::int32_t sum = 0;
        for (int k = 0; k < tool_rays; ++k) sum += ray[k];
        return sum;
    }
};

} // namespace crn
