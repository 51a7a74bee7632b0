// Writes lesions that a balloon can open, in the form that the core needs: stations along each lesion. A
// station holds centre and radius of the healthy vessel and of the narrowed channel (docs/lesions.md). The
// stations are given in the pose in which the lumen is described.
#pragma once
#include "host/model/vessel_tree.hpp"
#include "tools/bake/scene_text.hpp"

#include <cstdint>
#include <vector>

namespace crn::bake
{

// Returns the PLAQUES section with the first CRN_SCENE_PLAQUE_MAX lesions of the tree, or nothing if the tree
// has no lesions. `texts` must list the same lesions in the same order. Throws Fault for a lesion longer than
// 89 mm.
std::vector<std::uint8_t> plaques_section(const VesselTree &tree, const std::vector<LesionText> &texts);

} // namespace crn::bake
