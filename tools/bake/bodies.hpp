// Makes the bodies of a scene. Bodies that do not depend on each other are made at the same time, and the
// result does not depend on the number of processors.
#pragma once
#include "tools/bake/container.hpp"

namespace crn::bake
{

// Narrows the mesh of the lumen, or of the blood in the lumen, wherever a lesion lies. The returned list
// states for each vertex whether it moved; the list is empty if the tree has no lesion.
std::vector<bool> narrow(Mesh &mesh, const VesselTree &tree);

// Makes all bodies of the scene's text, in the order of the text, and adds their lines to `report` in the
// same order. Bodies of calcium follow. If several bodies have faults, the Fault of the first one is thrown.
std::vector<BakedBody> make_bodies(const SceneText &text, const Mesh &lumen, const VesselTree &tree,
                                   std::string &report, Progress &progress);

} // namespace crn::bake
