// Cuts out of a closed mesh the part on which the distances near some blocks of voxels depend. The finer
// levels of the field cover only a small part of a lumen, and a level set of the whole lumen would take most
// of the time of a bake.
#pragma once
#include "tools/bake/triangle_tree.hpp"
#include "tools/mesh/level_set/level_set.hpp"

namespace crn::bake
{

// Returns the part of the tree's mesh around the blocks, closed by squares where it was cut. A level set of
// the result, with a band of 9 voxels, equals the level set of the whole mesh in these blocks and in the
// blocks beside them. A block is a cube with an edge of `block_mm`, which is 8 voxels; block (0, 0, 0) has a
// corner in the origin.
Mesh near_part(const TriangleTree &tree, std::vector<mesh::Cell> blocks, double block_mm);

} // namespace crn::bake
