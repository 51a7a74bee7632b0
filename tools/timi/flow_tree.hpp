// Makes the tree of blood flow of an anatomy without baking a scene, as `bake` makes it from the anatomy's
// files.
#pragma once
#include "host/model/vessel_tree.hpp"
#include "tools/anatomy/vessels.hpp"

namespace anatomy
{

// The vessels are those of the patient at the end of diastole, with all small vessels.
crn::VesselTree flow_tree(const VesselTree &tree);

} // namespace anatomy
