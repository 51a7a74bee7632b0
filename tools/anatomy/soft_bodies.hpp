/* Makes the bodies other than bone: the layers of the trunk and the organs of the chest and the belly. The
 * bodies other than bone touch neither bones nor each other. */
#pragma once
#include "tools/anatomy/build.hpp"
#include "tools/anatomy/organs.hpp"
#include <algorithm>

namespace anatomy
{

/* The bones end at the heights BONE_BOTTOM_MM and BONE_TOP_MM, slightly inside the cuts where the skin ends.
 * The function beyond_cuts() is positive above BONE_TOP_MM and below BONE_BOTTOM_MM. */
constexpr double BONE_BOTTOM_MM = -422.0, BONE_TOP_MM = 344.0;

inline double beyond_cuts(const Vec3 &p)
{
    return std::max(BONE_BOTTOM_MM - p.y(), p.y() - BONE_TOP_MM);
}

inline Box grown(Box box, double margin_mm)
{
    box.low -= Vec3::Constant(margin_mm);
    box.high += Vec3::Constant(margin_mm);
    return box;
}

std::vector<Body> layer_bodies(const Solid &bones, double scale); // skin, fat under it, flesh

/* Returns the lungs with their vessels, the heart with its chambers, the airway, and the tree's coronary
 * arteries with the root of the aorta. The lungs leave space for the vessel tree, and the heart leaves space
 * for its coronary arteries. */
std::vector<Body> chest_bodies(const Solid &bones, const VesselTree &tree, double scale);
std::vector<Body> belly_bodies(const Solid &bones, double scale); // fat, organs, bowel with gas

} // namespace anatomy
