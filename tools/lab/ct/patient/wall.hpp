// Finds the wall of arteries at half the height between their blood and what is beside them.
#pragma once
#include "tools/lab/ct/arteries/body.hpp"
#include "tools/lab/ct/segment.hpp"

namespace crn::ct
{

// The arteries with a margin, cut out of the scan's grid. The mask is 1 in their voxels, and 2 in those of
// bridges.
struct Cut {
    Volume scan, mask;
};
Cut cut_arteries(const Volume &scan, const LabelMap &labels);

// The side of the cubes on which the wall is found: the smallest spacing of the scan, 0.7 to 1 mm.
double cube_of(const Volume &scan);
// Returns the volume on a grid of cubes with the same corners.
Volume in_cubes(const Volume &from, double cube_mm);

// Returns the level set of the arteries' wall in mm, negative inside, on a grid of cubes around the arteries
// of the label map. The wall may be up to a voxel outside the labelled voxels.
Volume wall_level(const Volume &scan, const LabelMap &labels, const Contrast &contrast, const Report &report);

} // namespace crn::ct
