// Proposes names for the branches of an arterial tree from where they leave the aorta, and where they go.
#pragma once
#include "tools/centreline/tree.hpp"

namespace crn::patient
{

// Names every branch of a tree whose first branch begins in the aorta; docs/own_ct.md has the rules. A vessel
// that is cut at junctions has numbers: aorta, aorta_2. What has no known name is branch_1, branch_2 and so
// on. The axes are those of the scene.
void propose_names(centreline::Tree &tree);

} // namespace crn::patient
