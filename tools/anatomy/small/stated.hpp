/* The arteries that are picture and flow only and whose courses files state: those of trunk and groin
 * (trunk_branches.toml), of neck and head (head_branches.toml) and of the arms (arm_branches.toml). */
#pragma once
#include "tools/anatomy/small/circle_of_willis.hpp"

namespace anatomy
{

/* Adds the shipped arteries to a tree in the patient's frame. Each one begins at its parent's centreline;
 * where the tree lacks the parent, it is left out. The tree's seed draws the circle of Willis and the
 * winding; without one, the circle is complete. */
void add_stated_branches(VesselTree &tree);

} // namespace anatomy
