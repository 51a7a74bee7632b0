// Path lengths: how much of each material every ray crosses. Everything from photons on (host/xray/chain.hpp)
// stands on these figures and knows nothing of meshes and tubes.
//
//     Bodies ──> BodyPaths (a back end: RasterPaths, or OpenGL) ──┐
//                                                                 ├──> PathKeeper ──> chain
//     tools on the wire, by exact chords (tube.hpp) ──────────────┘
//
// What a back end must deliver (see BodyPaths::draw): for each material and pixel one int32. Its unit is
// 1/1024 mm. Seen along the ray through the pixel's centre, (depth where it leaves) - (depth where it
// enters), over all faces of the bodies asked for. A body's sum is added to its own material and taken from
// its parent's, whatever lies between: so a body in a body in a body needs no sorting. RasterPaths is the
// reference; another may differ by rounding, and a test holds it within a stated distance of RasterPaths.
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

// One picture per material, size*size, row 0 on top, in 1/1024 mm; empty where the scene has none of the
// material.
using PathPictures = std::array<std::vector<std::int32_t>, material_count>;

// Pixels [x0, x1) x [y0, y1).
struct PixelRect {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    bool is_empty() const { return x0 >= x1 || y0 >= y1; }
};

enum class PathForm {
    axis_sums,   // along the central axis (depth), signed: may be added to other sums
    ray_lengths, // finished: along the ray, none below 0
};

// A back end that draws closed bodies. Made for one BodyMeshes, which outlives it; used by one thread at a
// time.
class BodyPaths
{
  public:
    virtual ~BodyPaths() = default;
    virtual std::string_view name() const = 0; // for messages and file headers: "raster", "opengl"

    // Other vertices for one body from now on, as many as it had.
    virtual void move(int body, std::span<const Eigen::Vector3i> vertices_um) = 0;

    // Sets every pixel of `rect`, in the pictures of all materials that the meshes' channels name, to the
    // sums of the bodies whose `is_drawn` is not 0 (one entry per body); the rest of each picture stays.
    // `pictures` has the right sizes already. Nothing nearer to the source than 1 mm is seen; what lies
    // behind it neither. False with a message when the device fails; PathKeeper then goes on with
    // RasterPaths.
    virtual bool draw(const View &view, std::span<const std::uint8_t> is_drawn, const PixelRect &rect,
                      PathForm form, PathPictures &pictures, std::string &error) = 0;
};

// Turns axis sums into ray lengths: columns [begin, end) of one row, in place.
void finish_row(const View &view, int row, int begin, int end, std::int32_t *line);

// What tools add to the bodies' paths. Only pixels with any tool in them have entries. Several rays cross
// each pixel, since tools are thin: a ray of a pixel has one length per material drawn.
inline constexpr int tool_rays = 9;

struct ToolPaths {
    int size = 0;
    std::vector<Material> materials;  // drawn in this frame
    std::vector<std::int32_t> pixels; // touched, row*size + column, each once, in drawing order
    std::vector<std::int32_t> entry;  // of each pixel of the picture: its place in `pixels`, -1 for none
    // [touched pixel][material][ray], 1/1024 mm; below 0: taken out of what was there (blood that metal
    // displaces).
    std::vector<std::int32_t> q10mm;

    std::size_t ints_per_pixel() const { return materials.size() * tool_rays; }
    // All rays of one touched pixel and one of `materials`, added up: tool_rays times the mean.
    std::int32_t sum(std::size_t touched, std::size_t material) const
    {
        const std::int32_t *ray = q10mm.data() + touched * ints_per_pixel() + material * tool_rays;
        std::int32_t sum = 0;
        for (int k = 0; k < tool_rays; ++k) sum += ray[k];
        return sum;
    }
};

} // namespace crn
