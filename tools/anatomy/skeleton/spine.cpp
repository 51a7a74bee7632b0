/* The spine from the atlas to the coccyx as one solid. */
#include "tools/anatomy/skeleton/levels.hpp"
#include "tools/anatomy/skeleton/spine_bend.hpp"
#include "tools/anatomy/skeleton/vertebral_body.hpp"
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
    shape.bend.kyphosis_deg = usual_added_kyphosis_deg(sex, age_years);
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

Solid vertebral_discs(const SkeletonShape &shape)
{
    constexpr double INTO_PLATES_MM = 2.5; // of each neighbour, whose end plates are hollow
    const auto spine = vertebrae(shape);
    Solid solid;
    for (size_t i = T1; i < L5; i++) {
        const Vertebra &v = spine[i], &below = spine[i + 1];
        const double high_mm = v.disc_below_mm + 2.0 * INTO_PLATES_MM;
        const Vec3 centre = v.centre_mm - 0.5 * (v.height_mm + v.disc_below_mm) * v.up;
        Part part(0.0);
        part.add<VertebralBody>(centre, frame_of(v).rotation,
                                BodyMeasures{v.width_mm, below.width_mm, 0.5 * (v.depth_mm + below.depth_mm),
                                             high_mm, high_mm, 0.0, 0.0, 0.0, 0.0});
        solid.add(part);
    }
    return solid;
}

} // namespace anatomy
