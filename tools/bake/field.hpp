// Makes the lumen's distance field from a closed mesh, as the lattice of bricks that firmware/core/lumen.h
// defines.
//
//   exact distances near the wall on a grid per level  ->  coefficients of the interpolating B-spline
//   ->  bricks, refined where the measured error exceeds the tolerance  ->  index, child rows, samples
#pragma once
#include "tools/bake/triangle_tree.hpp"
#include "tools/mesh/level_set/level_set.hpp"

#include <cstddef>
#include <cstdint>
// The core's headers are plain C without extern "C", so they are included within extern "C".
extern "C" {
#include "firmware/core/lumen.h"
}

namespace crn::bake
{

constexpr double mm_per_q30 = 1000.0 / 1073741824.0;
constexpr double voxel0_mm = 1000.0 / 1024.0; // level 0
constexpr double brick0_mm = 8 * voxel0_mm;
constexpr double error_band_mm = 1.5; // the field's error is measured this close to the wall

// This class holds a lumen and owns the arrays to which the lumen's pointers refer.
struct Field {
    crn_lumen lumen{};
    std::vector<std::uint16_t> index, children;
    std::vector<std::int8_t> samples;
    std::uint32_t row_first_rank = 0;
    std::array<std::uint32_t, 3> bricks_of_level{};

    const crn_lumen *view(); // sets the pointers
};

// Describes a box inside which the field must keep a stricter tolerance.
struct FineRegion {
    Eigen::AlignedBox3d box_mm;
    double tolerance_mm;
    int level_max;
};

struct FieldText {
    double tolerance_mm, inside_mm, outside_mm;
    int level_max;
    std::vector<FineRegion> fine = {};
};

// Throws Fault when the lumen needs more bricks (blocks of voxels) than a scene file can hold.
Field make_field(const TriangleTree &tree, const FieldText &text, Progress &progress);

// Cuts out of a closed mesh the part on which the distances near some blocks of voxels depend. The finer
// levels of a field cover only a small part of a lumen, and a level set of the whole lumen takes most of the
// time of a bake. The cut is closed by squares. A level set of the result, with a band of 9 voxels, equals
// the level set of the whole mesh in the blocks and in those beside them. A block is a cube of 8^3 voxels
// with an edge of `block_mm`, and block (0, 0, 0) has a corner in the origin.
Mesh near_part(const TriangleTree &tree, std::vector<mesh::Cell> blocks, double block_mm);

crn_vec3 to_q30(const Eigen::Vector3d &p_mm);

} // namespace crn::bake
