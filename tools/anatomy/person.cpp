#include "tools/anatomy/person.hpp"
#include <algorithm>
#include <cmath>

namespace anatomy
{

SkeletonShape skeleton_shape(const Person &person)
{
    return {person.sex,  person.osteophytes, person.cartilage_calcium, person.arms, person.age_years,
            person.bend, person.seed};
}

/* The fat under the skin grows in proportion to the body mass index above 13, at which hardly any is left. Of
 * the fat of the belly, men store more behind the wall than women. All figures are assumed, and were compared
 * with the volumes of the skin's mesh (docs/anatomy.md). */
SoftShape soft_shape(const Person &person)
{
    constexpr double LEAN_BMI = 13.0, FAT_LEAST = 0.3;
    const bool is_woman = person.sex == Sex::woman;
    const double above = person.bmi() - SHIPPED_BMI;
    SoftShape shape;
    shape.sex = person.sex;
    shape.fat =
        std::max(FAT_LEAST, (person.bmi() - LEAN_BMI) / (SHIPPED_BMI - LEAN_BMI)) * (is_woman ? 1.3 : 1.0);
    shape.belly_mm = above * (is_woman ? 1.6 : 2.4);
    if (is_woman) shape.breast_mm = std::clamp(52.0 + 1.5 * above, 40.0, 78.0);
    shape.gas = person.gas;
    shape.bowel_seed = person.seed;
    shape.wall_calcium = person.wall_calcium;
    shape.calcium_seed = person.seed + 1;
    shape.arms = person.arms;
    shape.bend = person.bend;
    return shape;
}

} // namespace anatomy
