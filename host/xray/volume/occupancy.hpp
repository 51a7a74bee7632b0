// Tells in constant time whether a box of a CT volume holds any tissue, so that rays skip the air.
//
// The volume is divided into bricks of 8^3 voxels. For each slab of bricks along an axis, a summed-area table
// counts the bricks that are not empty, so that four look-ups give their number in any rectangle.
#pragma once
#include "host/model/ct_volume.hpp"

namespace crn
{

inline constexpr int brick_edge = 8;

// Describes the slabs of bricks along one axis p. The axes q and r lie within a slab.
class SlabTable
{
  public:
    // `is_full` holds one number per brick, x fastest, then y, then z; `bricks` are their numbers along x, y,
    // z.
    SlabTable(const std::vector<std::uint8_t> &is_full, const std::array<int, 3> &bricks, int p, int q,
              int r);

    int slabs() const { return slabs_; }
    // True if any brick with a voxel in the rectangle q0 <= q <= q1, r0 <= r <= r1 of the slab is not empty.
    // The rectangle may reach outside the volume.
    bool has_tissue(int slab, int q0, int q1, int r0, int r1) const;

  private:
    int slabs_, across_, down_;     // bricks along p, q and r
    std::vector<std::int32_t> sum_; // [slab][r + 1][q + 1]
};

// Marks the bricks that hold a voxel other than air.
std::vector<std::uint8_t> full_bricks(const CtVolume &volume, std::array<int, 3> &bricks);

} // namespace crn
