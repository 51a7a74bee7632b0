// Helpers that several cases share: meshes that fit the inserter, and waiting for rest.
#pragma once
#include "tools/lab/validate/rig.hpp"

#include <string>

namespace crn::validate
{

// Returns the element length in whole micrometres for `count` free elements over a length. It is rounded up,
// so that the node at the inserter's end lies just inside and its joint's cell is clipped to the half element
// outside. If the end were slightly behind a node, the core would keep a tenth of a cell too much.
double element_length(double length_m, unsigned count);

// Steps until no node moves by more than `still_m` in 200 ticks, for at least 400 and at most `ticks_max`
// ticks. Returns the number of ticks.
int settle(Rig &rig, double still_m, int ticks_max);

// Formats 0.00185 as "1.85e-3", for names of figures.
std::string power_text(double value);
// Formats 0.5 as "0.5" and 10 as "10".
std::string plain_text(double value);

// Returns the place where a straight line through the last points (x, y) crosses y = 0.
double zero_of_line(const std::vector<double> &x, const std::vector<double> &y);

// Returns the turn of the tip segment about the rod. It is the angle of the chord from `node` to the tip,
// about the direction from the hand to the tip, against an axis carried without twist from the inserter. It
// uses geometry alone, in double precision.
double heading(const Rig &rig, unsigned node);

// Returns the representative of an angle that is nearest to another angle.
double unwrapped(double angle, double near);

constexpr double degree = 0.017453292519943295;
constexpr double gravity_m_s2 = 9.81;

} // namespace crn::validate
