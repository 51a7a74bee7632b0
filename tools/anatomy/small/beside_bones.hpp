/* Moves arteries whose courses files state out of the bones: a file states few points, and bones differ from
 * person to person. */
#pragma once
#include "tools/anatomy/shapes.hpp"
#include "tools/anatomy/vessels.hpp"

namespace anatomy
{

/* Returns the bones beside which a person's arteries of trunk and arms run. With the discs between the
 * vertebrae, and without the skull, whose canals its shape leaves out. */
Solid bones_beside(const SkeletonShape &shape);

/* Returns the artery with its course bent around the bones, so that its wall aims at 1.0 to 1.5 mm from them
 * at points 3 mm apart. Where bones leave no room, it comes nearer; persons had it up to 0.3 mm inside a
 * bone. Its start stays in the parent. An artery that keeps this distance anyway is returned as it is, and so
 * is a vertebral artery, which runs through openings of the vertebrae that their shapes leave out. */
Vessel beside_bones(const Vessel &artery, const Solid &bones);

} // namespace anatomy
