// Writes what the core needs beside the lumen: how walls give way, and the lesions that a balloon can open: a
// list of points ("stations") along each lesion. A station is a point along a lesion; it holds centre and
// radius of the healthy vessel and of the narrowed channel (docs/lesions.md). The stations (points along each
// lesion) are given in the same pose as the lumen.
#pragma once
#include "host/model/vessel_tree.hpp"
#include "tools/bake/field.hpp"
#include "tools/bake/scene_text.hpp"

#include <cstdint>
#include <vector>

namespace crn::bake
{

// Returns the PLAQUES section of the scene file, with the first CRN_SCENE_PLAQUE_MAX lesions of the tree; the
// section is empty if the tree has no lesions. The list `texts` must contain the same lesions as the tree, in
// the same order. Throws Fault for a lesion longer than 89 mm.
std::vector<std::uint8_t> plaques_section(const VesselTree &tree, const std::vector<LesionText> &texts);

// Returns the WALLS section, which states how the vessel's walls give way to the tools (docs/walls.md). Each
// coarse brick of the lumen's lattice gets the law of the vessel whose wall is nearest to the brick's middle.
// `tree` may be NULL if no law is that of a branch. Throws Fault for a name that no branch of the tree has,
// and for more laws than a scene can hold.
std::vector<std::uint8_t> walls_section(const WallsText &text, const Field &field, const VesselTree *tree);

} // namespace crn::bake
