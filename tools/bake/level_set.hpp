// Signed distances to a closed mesh on OpenVDB's grid.
#pragma once
#include "tools/bake/mesh.hpp"
#include "tools/bake/vdb.hpp"

namespace crn::bake
{

// Negative inside, in mm, kept `outside` and `inside` voxels far from the surface. Sample (i, j, k) lies at
// (i + place, j + place, k + place) * voxel_mm. Points are rounded to float in voxels: 1e-4 voxels at 1,000
// voxels from the origin. Ctrl-C ends it early with what is there.
openvdb::FloatGrid::Ptr level_set(const Mesh &mesh, double voxel_mm, double place, double outside,
                                  double inside);

} // namespace crn::bake
