/* The bodies other than bone, with everything that keeps them apart: layers of the trunk, chest, belly. */
#pragma once
#include "tools/anatomy/build.hpp"
#include "tools/anatomy/organs.hpp"
#include <algorithm>

namespace anatomy
{

/* The patient ends here; bones end slightly inside the skin's cuts. Positive outside. */
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
/* The root of the aorta and the coronary arteries, where there are any. Heart and lungs leave space for
 * them. */
struct HeartVessels {
    Solid root, left, right;
    Solid all() const;
};
HeartVessels heart_vessels();

/* Lungs with vessels, heart with chambers, airway, and the heart's vessels. */
std::vector<Body> chest_bodies(const Solid &bones, const HeartVessels &vessels, double scale);
std::vector<Body> belly_bodies(const Solid &bones, double scale); // fat, organs, bowel with gas

} // namespace anatomy
