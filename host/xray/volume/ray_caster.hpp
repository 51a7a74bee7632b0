// Casts rays through the CT of a patient (docs/xray.md, "A CT instead of meshes").
//
//     CtVolume ──> RayCaster::cast ──> RaySums, in mm of water ──> VolumePaths ──> path lengths per material
//
// The rays pass through the slices of the axis along which they make the most steps. The caster keeps the
// voxels twice, once with x and once with z as the fastest axis, so that neighbouring rays always read
// neighbouring voxels. It does not change after it was made, and any number of threads may use it.
#pragma once
#include "host/xray/paths/carm.hpp"
#include "host/xray/volume/occupancy.hpp"
#include "host/xray/volume/ray_bundle.hpp"
#include "host/xray/volume/voxel_rows.hpp"
#include <memory>

namespace crn
{

// The rays of a picture pass through the pixel positions first_px + i * step_px to the right and downwards.
// The middle of the first pixel is at 0.5.
struct RayGrid {
    int columns = 0, rows = 0; // whole tiles: multiples of ray_tile_columns and ray_tile_rows
    double first_px = 0.5, step_px = 1.0;
    std::size_t count() const { return std::size_t{1} * columns * rows; }
};
inline constexpr int ray_tile_columns = 32, ray_tile_rows = 8;

// Holds, for each ray of a grid, the integral of the attenuation along the ray in mm of water, and for each
// knot the integral of the part above the knot.
struct RaySums {
    std::vector<float> all_mm;
    std::array<std::vector<float>, knot_count> over_mm;
};

class RayCaster
{
  public:
    // The knots are thousandths of the attenuation of water.
    RayCaster(std::shared_ptr<const CtVolume> volume, const std::array<double, knot_count> &knots_permille);

    void cast(const View &view, const RayGrid &grid, int threads, RaySums &sums) const;
    const CtVolume &volume() const { return *volume_; }
    // Uses the version of the innermost loop without vectors; for tests.
    void use_plain_loop() { cast_slab_ = cast_slab_plain; }

  private:
    // Describes the slices along one axis.
    struct Slices {
        int p, q, r; // axes: across the slices, and fast and slow within them
        const std::uint16_t *voxels = nullptr;
        std::int32_t slice_stride = 0, row_stride = 0;
        std::unique_ptr<SlabTable> table;
    };
    struct Rays;
    struct Tile;
    int axis_across(const View &view) const;
    void aim(const Rays &rays, Tile &tile) const;
    void find_slabs(const Rays &rays, Tile &tile) const;
    void walk(const Rays &rays, Tile &tile) const;
    void write(const Rays &rays, const Tile &tile, RaySums &sums) const;
    Slices slices_of(int p, const std::vector<std::uint8_t> &is_full, const std::array<int, 3> &bricks) const;

    std::shared_ptr<const CtVolume> volume_;
    VoxelRows along_x_, along_z_;  // the voxels with x or z as the fastest axis; y is the slowest
    std::array<Slices, 3> slices_; // along x, y and z
    std::array<std::int32_t, knot_count> knots_;
    CastSlab cast_slab_;
};

} // namespace crn
