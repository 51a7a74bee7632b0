// Makes the flow tree of the shipped heart with its small vessels.
#pragma once
#include "host/model/vessel_tree.hpp"

namespace crn::literature
{

VesselTree heart_flow_tree();

// Returns the number of a branch; throws std::runtime_error if the tree has none of this name.
std::size_t branch_named(const VesselTree &tree, const std::string &name);

inline constexpr double blood_mPa_s = 3.5;

} // namespace crn::literature
