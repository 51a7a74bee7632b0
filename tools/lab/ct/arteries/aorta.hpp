// Finds the aorta in a CT with contrast medium, without a click and without a label map: as the longest stack
// of bright, round, even discs in axial slices.
#pragma once
#include "tools/lab/ct/arteries/body.hpp"

namespace crn::ct
{

struct Disc {
    int slice = 0;
    Eigen::Vector2d middle = Eigen::Vector2d::Zero(); // in voxels of the slice
    double radius_mm = 0.0, mean_HU = 0.0, noise_HU = 0.0;
    double share = 0.0; // of the directions in which the edge lies on the circle
};

// Discs of neighbouring slices that belong to one vessel, from the feet to the head.
using Stack = std::vector<Disc>;

// Returns all stacks of discs of at least `least_mm`, the longest and brightest first.
std::vector<Stack> round_stacks(const Volume &scan, double least_mm);

// Returns the stack of the descending aorta: the longest one. Throws Fault if there is none of 40 mm.
Stack descending_aorta(const std::vector<Stack> &stacks, const std::string &name);

// Median of the discs' means, and of their noise.
Contrast contrast_of(const Stack &stack);

Eigen::Vector3d place_of(const Volume &scan, const Disc &disc);

} // namespace crn::ct
