/* Makes the bodies other than bone: the layers of the trunk and the organs of the chest and the belly. The
 * bodies other than bone touch neither bones nor each other. */
#pragma once
#include "tools/anatomy/build.hpp"
#include "tools/anatomy/organs.hpp"
#include <algorithm>

namespace anatomy
{

/* The femurs end at the height BONE_BOTTOM_MM, slightly inside the cut where the skin ends. The function
 * beyond_cuts() is positive below. */
constexpr double BONE_BOTTOM_MM = -422.0;

inline double beyond_cuts(const Vec3 &p)
{
    return BONE_BOTTOM_MM - p.y();
}

inline Box grown(Box box, double margin_mm)
{
    box.low -= Vec3::Constant(margin_mm);
    box.high += Vec3::Constant(margin_mm);
    return box;
}

/* Skin, fat under it, the glands of breasts in it, and flesh. */
std::vector<Body> layer_bodies(const SoftShape &shape, const Solid &bones, double scale);

/* Returns the lungs with their vessels, the heart with its chambers, the airway, and the tree's coronary
 * arteries with the root of the aorta. The lungs leave space for the vessel tree, and the heart leaves space
 * for its coronary arteries. */
std::vector<Body> chest_bodies(const SoftShape &shape, const Solid &bones, const VesselTree &tree,
                               double scale);
/* Fat, organs, bowel with gas, and the calcium in the wall of the vessels of chest and belly. */
std::vector<Body> belly_bodies(const SoftShape &shape, const Solid &bones, const VesselTree &tree,
                               double scale);

} // namespace anatomy
