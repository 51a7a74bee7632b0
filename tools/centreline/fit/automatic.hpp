// Fully automatic: inlet and outlets, branches and their junctions found from the mesh alone.
#pragma once
#include "tools/centreline/fit/grow.hpp"

#include <optional>

namespace crn::centreline
{

struct AutoWish {
    GrowWish grow;
    std::optional<Eigen::Vector3d> inlet_mm; // else the widest opening, else the widest end
    double prune = 1.0; // a branch is kept if it goes on so many radii of the vessel it leaves beyond that
                        // vessel's cover
    double shortest_mm = 2.0; // and at least so far
};

// Longest way first: the way to the farthest place that no branch covers yet becomes the next branch, or is
// pruned. A branch covers what lies within 1.5 radii of its line. Branches end at junctions and are named
// 1, 1.1, 1.2, 1.2.1 ...
Tree fit_automatic(const Lumen &lumen, const AutoWish &wish, std::vector<std::string> &notes,
                   bake::Progress &progress);

} // namespace crn::centreline
