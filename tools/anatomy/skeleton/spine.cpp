/* The spine from the atlas to the coccyx as one solid. */
#include "tools/anatomy/skeleton/levels.hpp"
#include <algorithm>

namespace anatomy
{

SkeletonShape usual_skeleton(Sex sex, double age_years)
{
    // Osteophytes are rare before 40 years and present in 75 to 90 % of people beyond 60. Calcium of the
    // costal cartilages is rare before 30 years and then covers 7 % more of their length in ten years (205 CT
    // scans).
    SkeletonShape shape;
    shape.sex = sex;
    shape.age_years = age_years;
    shape.osteophytes = std::clamp((age_years - 40.0) / 65.0, 0.0, 1.0);
    shape.cartilage_calcium = std::clamp(0.007 * (age_years - 30.0), 0.0, 1.0);
    return shape;
}

Solid spine_bones(const SkeletonShape &shape)
{
    Solid solid;
    const auto spine = vertebrae(shape);
    for (size_t i = 0; i < spine.size(); i++)
        solid.add(i < T1 ? cervical_part(spine, i) : vertebra_part(spine, i, shape));
    solid.add(sacrum_part(spine, shape));
    return solid;
}

} // namespace anatomy
