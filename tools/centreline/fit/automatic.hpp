// Fits a tree fully automatically: inlet, outlets, branches and their junctions are found from the mesh
// alone.
#pragma once
#include "tools/centreline/fit/grow.hpp"

#include <optional>

namespace crn::centreline
{

struct AutoWish {
    GrowWish grow;
    std::optional<Eigen::Vector3d> inlet_mm; // empty: the widest opening, or else the widest end
    double prune = 1.0; // a branch is kept if it extends this many radii of the vessel it leaves beyond that
                        // vessel's cover ...
    double shortest_mm = 2.0; // ... and at least this far
};

// The fit takes the longest path through the vessels first. The path to the farthest place that no branch
// covers yet becomes the next branch, or it is pruned. A branch covers all places within 1.5 radii of its
// line. Branches end at junctions and are named 1, 1.1, 1.2, 1.2.1 ...
Tree fit_automatic(const Lumen &lumen, const AutoWish &wish, std::vector<std::string> &notes,
                   bake::Progress &progress);

} // namespace crn::centreline
