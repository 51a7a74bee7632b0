/* The veins in which medium is seen again after it has passed the heart or the kidneys. Courses and diameters
 * are assumed; each vein begins where its blood leaves it, and its last point is the farthest. */
#pragma once
#include "tools/anatomy/small/heart_tissue.hpp"
#include "tools/anatomy/small/small_tree.hpp"

namespace anatomy
{

std::vector<SmallVessel> coronary_veins(const HeartTissue &heart);
std::vector<SmallVessel> renal_veins();

} // namespace anatomy
