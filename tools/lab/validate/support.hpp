// What several cases share: meshes that fit the mouth, and waiting for rest.
#pragma once
#include "tools/lab/validate/rig.hpp"

#include <string>

namespace crn::validate
{

// Element length in whole micrometres for `count` free elements over a length. It is rounded up, so that the
// node at the mouth lies just inside the inserter and the cell of its joint is clipped to the half element
// outside: with the mouth a little behind a node the core keeps a tenth of a cell too much.
double element_length(double length_m, unsigned count);

// Steps until no node moves by more than `still_m` in 200 ticks, at least 400 and at most `ticks_max`.
// Returns the ticks.
int settle(Rig &rig, double still_m, int ticks_max);

// 0.00185 -> "1.85e-3", for names of figures.
std::string power_text(double value);
// 0.5 -> "0.5", 10 -> "10".
std::string plain_text(double value);

// Where a straight line through the last points (x, y) crosses y = 0.
double zero_of_line(const std::vector<double> &x, const std::vector<double> &y);

// Turn of the tip segment about the rod: angle, about the direction from the hand to the tip, of the chord
// from `node` to the tip against an axis carried without twist from the mouth. By geometry alone, in double
// precision.
double heading(const Rig &rig, unsigned node);

// The representative of an angle nearest to another.
double unwrapped(double angle, double near);

constexpr double degree = 0.017453292519943295;
constexpr double gravity_m_s2 = 9.81;

} // namespace crn::validate
