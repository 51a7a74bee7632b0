// Lesions that yield, in the form that the core needs: stations along each lesion with centre and radius of
// the healthy vessel and of the narrowed channel (docs/lesions.md). They are given in the pose in which the
// lumen is described.
#pragma once
#include "host/model/vessel_tree.hpp"
#include "tools/bake/scene_text.hpp"

#include <cstdint>
#include <vector>

namespace crn::bake
{

// The PLAQUES section; empty: no lesions. It holds the first CRN_SCENE_PLAQUE_MAX lesions of the tree,
// which are those of `texts` in the same order. Throws Fault for a lesion longer than 89 mm.
std::vector<std::uint8_t> plaques_section(const VesselTree &tree, const std::vector<LesionText> &texts);

} // namespace crn::bake
