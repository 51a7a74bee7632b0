// Semi-automatic: a person gives start, end and bifurcation points, the tool everything between. And what it
// would propose.
#pragma once
#include "tools/centreline/fit/grow.hpp"
#include "tools/centreline/fit/points.hpp"

namespace crn::centreline
{

// A tree with a branch from each point to the next. `notes` gets what was moved or looks odd. Throws Fault
// naming the point and what to do.
Tree fit_points(const Lumen &lumen, const std::vector<Point> &points, const GrowWish &wish,
                std::vector<std::string> &notes, bake::Progress &progress);

// Start, bifurcations and ends of a tree, named as its branches.
std::vector<Point> points_of(const Tree &tree);

} // namespace crn::centreline
