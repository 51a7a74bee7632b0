// Finds the ways that instruments may take from an entry into a tree of vessels, and how narrow they are.
#pragma once
#include "tools/patient/entry.hpp"

#include <Eigen/Geometry>

namespace crn::patient
{

struct WayPlace {
    std::size_t branch, sphere;
    double from_entry_mm;
    double radius_mm; // infinite where the way crosses another vessel's lumen
    Eigen::Vector3d place_mm;
};

// A tool that nobody turns may go into any of the wide vessels of a junction. So the ways go on into those
// that are at least 0.6 as wide as the widest one. They begin `inside_mm` behind the end, and lead up and
// down the tree. The places are in no order.
std::vector<WayPlace> ways_from(const centreline::Tree &tree, const TreeEnd &end, double inside_mm);

// The narrowest place up to this distance; nullptr if the ways cross other lumens only.
const WayPlace *narrowest(const std::vector<WayPlace> &ways, double to_mm);
// The distance up to which no way is narrower than `radius_mm`; infinite if none ever is.
double wide_up_to_mm(const std::vector<WayPlace> &ways, double radius_mm);

// The box of what medium from a catheter shows, whose end lies between these distances from the entry: the
// ways there, and the vessels that blood reaches within `reach_mm` from there.
Eigen::AlignedBox3d shown_from(const centreline::Tree &tree, const std::vector<WayPlace> &ways,
                               double least_mm, double most_mm, double reach_mm);

} // namespace crn::patient
