// Fits a vessel tree automatically: the functions find the inlet, outlets, branches and junctions from the
// mesh alone.
#pragma once
#include "tools/centreline/fit/grow.hpp"

#include <optional>

namespace crn::centreline
{

struct AutoWish {
    GrowWish grow;
    std::optional<Eigen::Vector3d> inlet_mm; // empty: the widest opening, or else the widest end
    // The direction of the head, if it is known: of ends of an aorta (6 mm radius) whose widths differ by
    // less than a tenth, blood enters at the highest.
    std::optional<Eigen::Vector3d> head;
    double prune = 1.0; // a branch is kept if it extends this many radii of the vessel it leaves beyond that
                        // vessel's cover ...
    double shortest_mm = 2.0; // ... and at least this far
};

// The first branch of the tree is the longest path through the vessels. Each further branch is the path to
// the farthest point that no branch covers yet, unless this path is too short for a branch. A branch covers
// all points within 1.5 vessel radii of its centreline. Branches end at junctions and are named 1, 1.1, 1.2,
// 1.2.1 ...
Tree fit_automatic(const Lumen &lumen, const AutoWish &wish, std::vector<std::string> &notes,
                   bake::Progress &progress);

} // namespace crn::centreline
