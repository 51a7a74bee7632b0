// Provides functions that several validation cases use: one computes element lengths that fit the introducer,
// and one waits until the rod is at rest.
#pragma once
#include "tools/lab/validate/rig.hpp"

#include <string>

namespace crn::validate
{

// Returns the element length, in whole micrometres, with which `count` elements outside the introducer have
// the given total length. The element length is rounded up, so that the node at the introducer's end lies
// just inside the introducer. With a node just inside the introducer, the joint at the introducer's end
// represents only the half element that is outside the introducer. If the introducer's end were slightly
// behind a node, the length that a joint represents would be 10 % too large in the core.
double element_length(double length_m, unsigned count);

// Advances the simulation until no node moves by more than `still_m` in 200 ticks, for at least 400 and at
// most `ticks_max` ticks. Returns the number of ticks.
int settle(Rig &rig, double still_m, int ticks_max);

// Formats a number such as 0.00185 as "1.85e-3", for use in the names of values.
std::string power_text(double value);

// Returns the x at which a straight line through the last two points (x, y) crosses y = 0.
double zero_of_line(const std::vector<double> &x, const std::vector<double> &y);

// Returns the angle by which the segment at the tip is turned about the rod. The returned angle is that of
// the chord from `node` to the tip, about the direction from the hand to the tip. The angle is measured from
// an axis that follows the rod without twist from the introducer. The angle is computed from positions alone,
// in double precision.
double heading(const Rig &rig, unsigned node);

// Adds full turns to `angle` until the result is as near as possible to `near`.
double unwrapped(double angle, double near);

constexpr double degree = 0.017453292519943295;
constexpr double gravity_m_s2 = 9.81;

} // namespace crn::validate
