// Walks eight rays together through slices of a CT volume. This is the innermost loop of the ray caster.
//
// The axis p of the slices is the one along which the rays pass from slice to slice; q and r are the axes
// within a slice (Joseph, IEEE Trans. Med. Imaging 1 (1982) 192). In each slice a ray reads the four voxels
// around it, weighted bilinearly with 7 bits along q and r. All arithmetic is in whole numbers, so that every
// processor gives the same sums.
#pragma once
#include "host/xray/paths/lanes.hpp"
#include <cstdint>

namespace crn
{

inline constexpr int knot_count = 4;
inline constexpr int sum_bits = 4; // sums are in 1/16 of a thousandth of water

struct alignas(32) RayBundle {
    // Position at slice 0, and step from slice to slice, in 1/65536 voxel.
    std::int32_t q[lane_count], r[lane_count], step_q[lane_count], step_r[lane_count];
    std::uint32_t all[lane_count];              // sum of the values along the ray
    std::uint32_t over[knot_count][lane_count]; // sums of max(value, knot)
};

// Describes slices first ... end - 1 of a volume.
struct SlabOfSlices {
    const std::uint16_t *voxels = nullptr;         // voxel 0 of slice 0
    std::int32_t slice_stride = 0, row_stride = 0; // from p to p + 1, and from r to r + 1; that of q is 1
    int first = 0, end = 0;
    // A ray counts where 0 <= q < q_limit and 0 <= r < r_limit, in 1/65536 voxel. Elsewhere there is air.
    std::int32_t q_limit = 0, r_limit = 0;
    bool is_inside = false;              // all rays are within the limits in all slices
    std::int32_t knots[knot_count] = {}; // in the unit of the sums
};

using CastSlab = void (*)(const SlabOfSlices &slab, RayBundle *bundles, int count);

// Returns the fastest version for this processor. The versions give equal sums.
CastSlab choose_cast_slab();
// The version without vectors, for tests.
void cast_slab_plain(const SlabOfSlices &slab, RayBundle *bundles, int count);

} // namespace crn
