// Finds the path through the instrument's voxels from end to end.
#pragma once
#include "tools/lab/ct/centreline.hpp"

namespace crn::ct
{

// Returns places (scene, mm) along the ridge from the introducer's end to the tip. Throws Fault where the
// voxels branch.
std::vector<Eigen::Vector3d> path_through(const Volume &volume, const Volume &mask,
                                          const LineOptions &options, std::vector<std::string> &notes);

} // namespace crn::ct
