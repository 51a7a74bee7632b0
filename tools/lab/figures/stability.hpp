// Determines the number of steps per millisecond that a preset needs. The needed number is the smallest with
// which a short rod survives compression in a closed tube. The number of substeps in the presets has a margin
// above it.
#pragma once
#include "tools/lab/figures/compression.hpp"

namespace vcsim3
{

// Makes a straight tube along +x from the origin, closed by a plane at `length_m`; the distances to its wall
// are exact.
Wall tube_wall(double radius_m, double length_m);

// Pushes 64 elements of the preset (96 mm) at 0.1 m/s into a tube of 85 mm. Returns true if no segment grows
// by a tenth of its length.
bool survives_crowding(const Preset &preset, const Mode &mode, int substeps);

// Searches by bisection between 1 and twice the preset's substeps; returns 0 when even twice the substeps
// fail.
int smallest_stable_substeps(const Preset &preset, const Mode &mode, const Watch &watch);

} // namespace vcsim3
