// The number of steps per millisecond that a preset needs: the smallest with which a short rod survives
// compression in a closed tube. The presets' substeps keep a margin above it.
#pragma once
#include "tools/lab/figures/compression.hpp"

namespace vcsim3
{

// A straight tube along +x from the origin, closed by a plane at `length_m`; the distance is exact.
Wall tube_wall(double radius_m, double length_m);

// Pushes 64 elements of the preset (96 mm) at 0.1 m/s into a tube of 85 mm. No segment may grow by a tenth.
bool survives_crowding(const Preset &preset, const Mode &mode, int substeps);

// Bisects between 1 and twice the preset's substeps; returns 0 when even those fail.
int smallest_stable_substeps(const Preset &preset, const Mode &mode, const Watch &watch);

} // namespace vcsim3
