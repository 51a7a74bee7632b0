// Lesions that give way, as the core wants them: stations along each, with middle and radius of the healthy
// vessel and of what is left (docs/lesions.md). In the pose that the lumen is described in.
#pragma once
#include "host/model/vessel_tree.hpp"
#include "tools/bake/scene_text.hpp"

#include <cstdint>
#include <vector>

namespace crn::bake
{

// The PLAQUES section; empty: no lesions. The first CRN_SCENE_PLAQUE_MAX of the tree's lesions, which are
// those of `texts` in their order. Throws Fault for one longer than 89 mm.
std::vector<std::uint8_t> plaques_section(const VesselTree &tree, const std::vector<LesionText> &texts);

} // namespace crn::bake
