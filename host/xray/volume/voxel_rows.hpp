// Holds the voxels of a CT in the order in which the ray caster reads them: rows along x (or along z), planes
// of rows, and the planes from foot to head.
#pragma once
#include "host/model/ct_volume.hpp"

namespace crn
{

class VoxelRows
{
  public:
    // With `is_turned` the rows run along z and follow each other along x; otherwise the other way round.
    VoxelRows(const CtVolume &volume, bool is_turned);
    ~VoxelRows();
    VoxelRows(const VoxelRows &) = delete;
    VoxelRows &operator=(const VoxelRows &) = delete;

    const std::uint16_t *voxels() const { return voxels_; }
    std::int32_t row_stride() const { return row_stride_; }
    std::int32_t plane_stride() const { return plane_stride_; }

  private:
    std::int32_t row_stride_, plane_stride_;
    std::uint16_t *voxels_;
};

} // namespace crn
