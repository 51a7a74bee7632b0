/* Grows the pulmonary arteries and veins of a lung down to a width of 1 mm. They are bodies of the picture
 * only. Wide vessels become a solid, whose level set joins them smoothly; narrow ones are polygonal tubes,
 * because a level set fine enough for them would take minutes. */
#pragma once
#include "tools/anatomy/soft/lung_space.hpp"
#include <vector>

namespace anatomy
{

/* The narrowest vessels are 1 mm wide. */
constexpr double LUNG_END_RADIUS_MM = 0.5;

/* One vessel, from the middle of the vessel from which it leaves to its end. At a fork it follows the wider
 * branch. */
struct LungVessel {
    Curve course;
    double parent_radius_mm = 0.0; // of the vessel from which it leaves; 0 at the hilum
    Vec3 parent_direction = Vec3::UnitY();
};

struct LungTree {
    std::vector<LungVessel> vessels;
    size_t ends = 0;
};

enum class LungSide { right, left };

/* Grow to evenly spread ends in the lung; arteries from the pulmonary artery, veins from the lower hilum. */
LungTree lung_arteries(LungSide side, const LungSpace &space, const Box &box);
LungTree lung_veins(LungSide side, const LungSpace &space, const Box &box);

/* The part of the trees that is wider than 4.4 mm. It begins in the hilum, outside the lung. */
Solid wide_lung_vessels(const std::vector<LungTree> &trees);

/* The narrower part: closed tubes of 3 to 6 sides that have the area of the round vessel. They begin at the
 * surface of the vessel from which they leave. What comes too near to the lung's surface is left out. */
Mesh narrow_lung_vessels(const std::vector<LungTree> &trees, const LungSpace &space);

} // namespace anatomy
