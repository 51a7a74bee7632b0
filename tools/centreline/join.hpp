// Joins separate curves to a tree: which curve begins inside which.
#pragma once
#include "tools/centreline/tree.hpp"

#include <cmath>
#include <functional>

namespace crn::centreline
{

// One end of a curve that is not yet in the tree, and the branch of the tree in whose tube it lies deepest.
struct Joint {
    std::size_t curve = 0, parent = 0;
    bool is_last = false;    // it is the curve's last point: the curve runs against the blood flow
    double depth = INFINITY; // smaller is deeper; INFINITY: it lies in no branch
};

// How deep the first or last point of a curve lies in a branch of the tree so far; smaller is deeper.
using DepthOf = std::function<double(std::size_t curve, bool is_last, std::size_t branch)>;

// Grows a tree of `count` curves. `first` begins it; then, again and again, the end that lies deepest in a
// branch so far joins that branch. `place` must append the joint's curve to the tree as its last branch. Of
// equal ends the one of the earlier curve, then of the earlier branch, then the first point is chosen. The
// caller decides what depth is, and what happens to a curve that lies in no branch.
void grow_tree(std::size_t count, std::size_t first, const DepthOf &depth,
               const std::function<void(const Joint &)> &place);

// Makes a tree from curves as 3D Slicer and VMTK store them, which is one curve per file or per outlet. A
// root that begins inside another branch's tube becomes a branch of it; the part of the root that runs along
// that branch's line is cut off. The trunk is the curve that has an end nearest to `inlet_mm`; without
// `inlet_mm` it is the widest curve. A lone curve is not changed, nor is a tree whose file states which
// branch leaves which.
Tree joined(const Tree &tree, const Eigen::Vector3d *inlet_mm = nullptr);

} // namespace crn::centreline
