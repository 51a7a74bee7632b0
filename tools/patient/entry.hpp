// Chooses the place where instruments enter a tree of vessels.
#pragma once
#include "tools/centreline/tree.hpp"

#include <string>
#include <vector>

namespace crn::patient
{

// A place inside an end of the tree, and the direction from this end into the vessel.
struct Entry {
    Eigen::Vector3d place_mm, direction;
    std::string branch;
    double inside_mm; // from the end
};

constexpr double entry_mm = 15.0; // from the end of the vessel into it, where nothing else is asked

// An end of the tree: the last sphere of a branch without children, or the root's first sphere.
struct TreeEnd {
    std::size_t branch = 0;
    bool is_root = false;
    Eigen::Vector3d place_mm = Eigen::Vector3d::Zero();
    double radius_mm = 0; // in the middle of its branch
};
std::vector<TreeEnd> ends_of(const centreline::Tree &tree);

// Where the mesh of a vessel closes, flat or round, the inscribed spheres of the last three radii become
// small: they get the radius of the vessel behind them. Otherwise an outlet would take hardly any flow, which
// grows with the cube of its radius.
void widen_closed_ends(centreline::Tree &tree);

// Returns the place `inside_mm` along the vessel from an end, and the direction from the end into the vessel.
// Throws Fault for a branch with a single sphere.
Entry inside_end(const centreline::Tree &tree, const TreeEnd &end, double inside_mm = entry_mm);

// The end at which instruments usually enter: the widest of the ends near the feet. Beside the femoral
// artery, its deep branch often ends lower, so all ends up to 60 mm above the lowest one count. The blood's
// inlet does not count. Throws Fault if the tree has no end.
TreeEnd low_end(const centreline::Tree &tree);
// The end, except the blood's inlet, that is nearest to the place.
TreeEnd end_near(const centreline::Tree &tree, const Eigen::Vector3d &place_mm);

} // namespace crn::patient
