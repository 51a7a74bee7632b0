// Computes signed distances to a closed mesh on OpenVDB's grid.
#pragma once
#include "tools/bake/mesh.hpp"
#include "tools/bake/vdb.hpp"

namespace crn::bake
{

// Distances are in mm and negative inside; they are kept up to `outside` and `inside` voxels from the
// surface. Sample (i, j, k) lies at (i + place, j + place, k + place) * voxel_mm. Points are rounded to float
// in units of voxels: the error is 1e-4 voxels at 1,000 voxels from the origin. Ctrl-C ends the work early,
// and the unfinished grid is returned.
openvdb::FloatGrid::Ptr level_set(const Mesh &mesh, double voxel_mm, double place, double outside,
                                  double inside);

} // namespace crn::bake
