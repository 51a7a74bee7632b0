// Fits a tree semi-automatically: a person gives start, end and bifurcation points, and the tool finds the
// branches between them. The tool can also propose such points.
#pragma once
#include "tools/centreline/fit/grow.hpp"
#include "tools/centreline/fit/points.hpp"

namespace crn::centreline
{

// Makes a tree with a branch from each point to the next. `notes` lists points that were moved or whose
// position is doubtful. Throws Fault that names the point and the remedy.
Tree fit_points(const Lumen &lumen, const std::vector<Point> &points, const GrowWish &wish,
                std::vector<std::string> &notes, bake::Progress &progress);

// Returns the start, bifurcations and ends of a tree, named after its branches.
std::vector<Point> points_of(const Tree &tree);

} // namespace crn::centreline
