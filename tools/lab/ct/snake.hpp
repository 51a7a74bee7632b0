// Computes level sets on a volume's grid with the library ITK, which this header does not include. The steps
// are smoothing, edges, distance and the snake (active contour). The snake is ITK-SNAP's name for the
// geodesic active contour (Caselles, Kimmel and Sapiro 1997). A level is a volume whose values are distances
// from the surface in mm, negative inside.
#pragma once
#include "tools/lab/ct/volume/volume.hpp"

namespace crn::ct
{

Volume smoothed(const Volume &volume, double sigma_mm);
// Smooths the volume by a Gaussian of width sigma, and returns the magnitude of its gradient in HU per mm.
Volume gradient_magnitude(const Volume &volume, double sigma_mm);
// Returns the speed of the snake (active contour): 1 in even regions and 0 at edges; the speed is 0.5 where
// the gradient is `edge_HU_per_mm`.
Volume speed_of(const Volume &gradient, double edge_HU_per_mm, double width_HU_per_mm);
// Returns the signed distance from the border of a mask, which consists of the voxels with a value above 0.
Volume signed_distance(const Volume &mask);

struct SnakeWeights {
    double propagation = 0; // outwards, in even regions
    double curvature = 0.2; // against bends
    double advection = 1;   // towards edges
    int iterations = 40;
};
// Moves the snake (active contour) by the given number of steps, and returns the signed distance from the
// moved contour. The library ITK runs on one thread in these functions, so their results are deterministic.
Volume evolve_snake(const Volume &level, const Volume &speed, const SnakeWeights &weights);

} // namespace crn::ct
