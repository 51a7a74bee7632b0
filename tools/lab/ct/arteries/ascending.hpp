// Finds the ascending aorta among the round stacks, and the plane below its root.
#pragma once
#include "tools/lab/ct/arteries/aorta.hpp"
#include "tools/lab/ct/arteries/growth.hpp"

namespace crn::ct
{

// Returns the stack of the ascending aorta and, below it, of the root; empty where the scan has none. The
// growth is one from the descending aorta.
Stack ascending_aorta(const Volume &scan, const Growth &growth, const std::vector<Stack> &stacks,
                      const Stack &descending);

// The voxels of the plane below the aortic root, which closes the way into the ventricle.
std::vector<std::size_t> gate_below(const Volume &scan, const Stack &ascending);

} // namespace crn::ct
