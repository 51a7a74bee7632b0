// Computes the mean flows in the small vessels of a tree, which are picture and flow only.
#pragma once
#include "host/model/vessel_tree.hpp"
#include <vector>

namespace crn
{

// Returns for each small vessel the mean flow into its beginning, in ml/s; for a vein, 0. An end from which
// no other small vessel continues has the flow that is stated for it, or the flow by Murray's law.
std::vector<double> small_vessel_flows_ml_s(const VesselTree &tree);

// Returns for each small vessel whether another one continues from its last point.
std::vector<bool> small_vessels_continued(const VesselTree &tree);

} // namespace crn
