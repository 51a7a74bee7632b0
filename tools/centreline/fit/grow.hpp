// Builds a vessel tree from rough paths, branch by branch, and completes the junctions and ends of the
// branches.
#pragma once
#include "tools/centreline/fit/line_fit.hpp"

namespace crn::centreline
{

struct GrowWish {
    double spacing = 0.5; // of neighbouring spheres, in radii
};

// The input for one branch.
struct Way {
    std::vector<Eigen::Vector3d> points_mm; // from its parent (or inlet) outwards
    std::string name;
    int parent = -1; // number of the parent branch in the tree
    bool leaves_at_end =
        false; // it begins at the parent's last sphere, not where the path leaves the parent's tube
    bool is_first_given = false; // a person gave the first point (or it is a junction): it stays
    bool is_last_given = false;  // likewise for the last; otherwise the end is found: at an opening's plane,
                                 // or at the last sphere that touches the far end
};

// Adds one branch to the tree and returns the number of the new branch. Throws Fault when the path is too
// short for a branch.
int grow_branch(Tree &tree, const Lumen &lumen, const Way &way, const GrowWish &wish);

// Returns the branch in whose tube the path stays for the longest distance; returns -1 if the path touches no
// branch.
int parent_of(const Tree &tree, const std::vector<Eigen::Vector3d> &way_mm);

// If the end of a path is near an opening, the function moves the path's end to the middle of the opening.
// Only ends that the user has not placed may be moved to an opening.
void finish_last(const Lumen &lumen, std::vector<Eigen::Vector3d> &points_mm);

} // namespace crn::centreline
