// Finds the path through the instrument's voxels from one end of the instrument to the other.
#pragma once
#include "tools/lab/ct/centreline.hpp"

namespace crn::ct
{

// Returns points (in the scene's axes, in mm) along the brightest line through the instrument, from the
// introducer's end to the tip. Throws Fault if the instrument's voxels form branches.
std::vector<Eigen::Vector3d> path_through(const Volume &volume, const Volume &mask,
                                          const LineOptions &options, std::vector<std::string> &notes);

} // namespace crn::ct
