// Finds what looks like a tube of blood with medium among the bright voxels of a CT (docs/own_ct.md,
// "Arteries without a label map").
#pragma once
#include "tools/lab/ct/arteries/aorta.hpp"
#include "tools/lab/ct/arteries/mask.hpp"

namespace crn::ct
{

// Marks the voxels of `inside` around which the brightness falls off in two directions and stays in the
// third: the eigenvalues of the Hessian on two scales, as in Sato et al., Medical Image Analysis 2 (1998),
// 143-168. What is brighter than blood counts as dark by as much, so that a tube beside a bone keeps its
// shape.
Mask tubes_of(const Volume &scan, const Mask &inside, const Contrast &contrast);

} // namespace crn::ct
