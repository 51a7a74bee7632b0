// Determines the number of time steps per millisecond that a preset (an instrument of the thesis) needs. The
// needed number of time steps is the smallest number with which a short rod stays stable when it is
// compressed in a closed tube. The number of substeps in a preset exceeds the needed number by a safety
// margin.
#pragma once
#include "tools/lab/figures/compression.hpp"

namespace vcsim3
{

// Makes a straight tube along +x that begins at the origin and ends at a plane at `length_m`; the distances
// to its wall are exact.
Wall tube_wall(double radius_m, double length_m);

// Pushes a rod of 64 elements (96 mm), with the preset's properties, at 0.1 m/s into a tube of 85 mm length.
// Returns true if no segment of the rod grows by a tenth of its length.
bool survives_crowding(const Preset &preset, const Mode &mode, int substeps);

// Searches by bisection between 1 and twice the preset's number of substeps; returns 0 when the rod is
// unstable even at the upper end.
int smallest_stable_substeps(const Preset &preset, const Mode &mode, const Watch &watch);

} // namespace vcsim3
