// Finds the path through the instrument's voxels from end to end.
#pragma once
#include "tools/lab/ct/centreline.hpp"

namespace crn::ct
{

// Returns places (in the scene's axes, in mm) along the brightest line from the introducer's end to the tip.
// Throws Fault if the voxels form branches.
std::vector<Eigen::Vector3d> path_through(const Volume &volume, const Volume &mask,
                                          const LineOptions &options, std::vector<std::string> &notes);

} // namespace crn::ct
