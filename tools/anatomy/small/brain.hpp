/* Grows arteries over the convexity of the brain, below the stated arteries of the head (head_branches.toml).
 */
#pragma once
#include "tools/anatomy/small/small_tree.hpp"

namespace anatomy
{

/* Returns the grown arteries; none if the tree has no cerebral arteries. */
std::vector<SmallVessel> brain_arteries(const VesselTree &tree);

} // namespace anatomy
