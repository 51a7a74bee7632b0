// Joins separate curves to a vessel tree by finding, for each curve, the branch inside which the curve
// begins.
#pragma once
#include "tools/centreline/tree.hpp"

#include <cmath>
#include <functional>

namespace crn::centreline
{

// Names one end of a curve that is not yet in the tree, and the branch of the tree in which this end lies
// deepest.
struct Joint {
    std::size_t curve = 0, parent = 0;
    bool is_last = false;    // it is the curve's last point: the curve runs against the blood flow
    double depth = INFINITY; // smaller is deeper; INFINITY: it lies in no branch
};

// Returns a number for the depth of a curve's first or last point in a branch of the tree; a smaller number
// means deeper.
using DepthOf = std::function<double(std::size_t curve, bool is_last, std::size_t branch)>;

// Joins `count` curves to a tree, one after another. The tree begins with the curve `first`. In each further
// step, the curve whose end lies deepest in a branch of the tree is joined to that branch. The callback
// `place` must append the curve of the given joint to the tree as the last branch. If two ends are equally
// deep, the earlier curve is chosen, then the earlier branch, and then the curve's first point. The caller
// defines how depth is measured, and what happens to a curve that lies in no branch.
void grow_tree(std::size_t count, std::size_t first, const DepthOf &depth,
               const std::function<void(const Joint &)> &place);

// Makes a vessel tree from the curves of 3D Slicer or VMTK, which store one curve per file or per outlet. A
// root that begins inside another branch becomes a child of that branch. If a root becomes a child of a
// branch, the part of the root that runs along the branch's centreline is cut off. The trunk is the curve
// with the end nearest to `inlet_mm`; without `inlet_mm` it is the widest curve. Parents that a file states
// stay: such a tree joins another one with the beginning of its root, or is turned so that it begins at
// `inlet_mm`. Appends to `notes` what was turned, and what stays apart. Throws Fault if no end lies near
// `inlet_mm`.
Tree joined(const Tree &tree, const Eigen::Vector3d *inlet_mm = nullptr,
            std::vector<std::string> *notes = nullptr);

} // namespace crn::centreline
