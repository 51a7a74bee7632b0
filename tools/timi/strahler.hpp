// Counts the vessels of a tree by Strahler's orders, as morphometry of arteries does.
#pragma once
#include "host/model/vessel_tree.hpp"
#include <string>
#include <vector>

namespace anatomy
{

// An element is a row of segments of one order; where two segments of one order meet, the order rises by one.
struct StrahlerOrder {
    int order = 0;
    size_t elements = 0;
    double diameter_mm = 0.0, length_mm = 0.0; // means of the elements
};

// The tree is a branch with everything that leaves it. An end has the order `lowest`.
std::vector<StrahlerOrder> strahler_orders(const crn::VesselTree &tree, const std::string &branch,
                                           int lowest);

} // namespace anatomy
