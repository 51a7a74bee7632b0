/* How a spine bends and how its left and right sides differ, from person to person. */
#pragma once
#include "tools/anatomy/skeleton.hpp"

namespace anatomy
{

/* Returns the kyphosis that is usual for a sex and an age in a person who lies on the back, less that of a
 * man of 60 years. */
double usual_added_kyphosis_deg(Sex sex, double age_years);

/* Returns the depth of the middle of the shipped man's spine at a height. */
double spine_course_z_mm(double y_mm);

/* Draws how the sides of a vertebra differ. */
SideDifference side_difference(std::uint32_t seed, size_t level);

} // namespace anatomy
