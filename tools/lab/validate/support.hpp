// Provides functions that several cases share: mesh lengths that fit the introducer, and waiting for rest.
#pragma once
#include "tools/lab/validate/rig.hpp"

#include <string>

namespace crn::validate
{

// Returns the element length in whole micrometres for `count` free elements over a length. The length is
// rounded up, so that the node at the introducer's end lies just inside. The cell of the joint at this node
// is then limited to the half element outside the introducer. If the introducer's end were slightly behind a
// node, the core would count a tenth of a cell too much.
double element_length(double length_m, unsigned count);

// Advances the rig until no node moves by more than `still_m` in 200 ticks, for at least 400 and at most
// `ticks_max` ticks. Returns the number of ticks.
int settle(Rig &rig, double still_m, int ticks_max);

// Formats 0.00185 as "1.85e-3", for the names of figures.
std::string power_text(double value);

// Returns the place where a straight line through the last two points (x, y) crosses y = 0.
double zero_of_line(const std::vector<double> &x, const std::vector<double> &y);

// Returns the angle by which the tip segment is turned about the rod. The angle is that of the chord from
// `node` to the tip, about the direction from the hand to the tip. The angle is measured from an axis carried
// without twist from the introducer. The computation of the angle uses only geometry, in double precision.
double heading(const Rig &rig, unsigned node);

// Adds to `angle` the multiple of a full turn that brings it nearest to `near`.
double unwrapped(double angle, double near);

constexpr double degree = 0.017453292519943295;
constexpr double gravity_m_s2 = 9.81;

} // namespace crn::validate
