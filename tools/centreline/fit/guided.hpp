// Semi-automatic fitting: a person gives start, end and bifurcation points, and the tool finds everything
// between. It can also propose such points.
#pragma once
#include "tools/centreline/fit/grow.hpp"
#include "tools/centreline/fit/points.hpp"

namespace crn::centreline
{

// Makes a tree with a branch from each point to the next. `notes` lists points that were moved or look odd.
// Throws Fault naming the point and the remedy.
Tree fit_points(const Lumen &lumen, const std::vector<Point> &points, const GrowWish &wish,
                std::vector<std::string> &notes, bake::Progress &progress);

// Returns the start, bifurcations and ends of a tree, named after its branches.
std::vector<Point> points_of(const Tree &tree);

} // namespace crn::centreline
