// Level sets on a volume's grid, computed by ITK behind a header that does not include it: smoothing, edges,
// distance, and the geodesic active contour (Caselles, Kimmel and Sapiro 1997) that ITK-SNAP calls a snake. A
// level is a volume whose values are mm from the surface, negative inside.
#pragma once
#include "tools/lab/ct/volume/volume.hpp"

namespace crn::ct
{

Volume smoothed(const Volume &volume, double sigma_mm);
// In HU per mm, of the volume smoothed by sigma.
Volume gradient_magnitude(const Volume &volume, double sigma_mm);
// The speed of the snake: 1 in even regions, 0 at edges; the sigmoid's middle is at `edge_HU_per_mm`.
Volume speed_of(const Volume &gradient, double edge_HU_per_mm, double width_HU_per_mm);
// The signed distance from the border of a mask (> 0 is inside).
Volume signed_distance(const Volume &mask);

struct SnakeWeights {
    double propagation = 0; // outwards, in even regions
    double curvature = 0.2; // against bends
    double advection = 1;   // towards edges
    int iterations = 40;
};
// Returns the level after the given number of steps. The function runs ITK on one thread, so the result is
// deterministic.
Volume evolve_snake(const Volume &level, const Volume &speed, const SnakeWeights &weights);

} // namespace crn::ct
