// A tree grows branch by branch from rough ways; junctions and ends are put in order.
#pragma once
#include "tools/centreline/fit/line_fit.hpp"

namespace crn::centreline
{

struct GrowWish {
    double spacing = 0.5; // of neighbouring spheres, in radii
};

// What one branch is made of.
struct Way {
    std::vector<Eigen::Vector3d> points_mm; // from its parent (or inlet) outwards
    std::string name;
    int parent = -1;             // branch of the tree
    bool leaves_at_end = false;  // the parent's last sphere, not where the way leaves its tube
    bool is_first_given = false; // the first point is a person's (or a junction): it stays
    bool is_last_given = false;  // likewise; else the end is found: at an opening's plane, or where the last
                                 // sphere that touches the far end lies
};

// The tree gets one more branch; its number is returned. Throws Fault when the way is too short to be a
// branch.
int grow_branch(Tree &tree, const Lumen &lumen, const Way &way, const GrowWish &wish);

// The branch along whose tube the way runs farthest before it leaves it; -1: it touches none.
int parent_of(const Tree &tree, const std::vector<Eigen::Vector3d> &way_mm);

// The ends of a way that nobody gave: at the middle of an opening that is near, or left as it is.
void finish_last(const Lumen &lumen, std::vector<Eigen::Vector3d> &points_mm);

} // namespace crn::centreline
