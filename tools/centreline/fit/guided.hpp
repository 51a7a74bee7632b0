// Fits a tree semi-automatically: a person gives start, end and bifurcation points, and the tool finds the
// branches between these points. The tool can also propose the start, end and bifurcation points.
#pragma once
#include "tools/centreline/fit/grow.hpp"
#include "tools/centreline/fit/points.hpp"

namespace crn::centreline
{

// Makes a vessel tree that has a branch from each point to the following point. `notes` receives remarks
// about points that were moved or whose position is doubtful. Throws a Fault whose message names the wrong
// point and the remedy.
Tree fit_points(const Lumen &lumen, const std::vector<Point> &points, const GrowWish &wish,
                std::vector<std::string> &notes, bake::Progress &progress);

// Returns the start, bifurcation and end points of a tree; each point has the name of a branch.
std::vector<Point> points_of(const Tree &tree);

} // namespace crn::centreline
