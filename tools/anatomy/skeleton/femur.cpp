/* The upper thirds of the femurs: heads of 48 mm (a woman: 43, for a stature of 0.93), necks that stand at
 * 133 degrees to the shaft and are turned forwards by 10.6 degrees (466 femurs), shafts with walls of 5 to
 * 7 mm, 3 to 4 mm at the calcar and 1 mm at the neck's upper side (common figures). All other measures are
 * assumed. */
#include "tools/anatomy/skeleton/levels.hpp"
#include <cmath>

namespace anatomy
{

namespace
{

Part femur_part(double s, bool woman)
{
    const double wider = woman ? WOMAN_PELVIS_WIDER : 1.0, head_mm = woman ? 23.1 : 24.0;
    const double shift = (wider - 1.0) * HIP_MM.x();
    const auto at = [&](double x, double y, double z) { return side(s, x + shift, y, z); };
    Part part(6.0);
    const auto rod = [&](const std::vector<Vec3> &points, const std::vector<double> &radii,
                         double cortex_mm) -> Tube & { return part.rod(points, radii, cortex_mm); };
    part.add<Ellipsoid>(at(HIP_MM.x(), HIP_MM.y(), HIP_MM.z()), Vec3::Constant(head_mm)).cortex_mm = 0.9;
    // The neck is oval, higher than deep, and narrowest just below the head.
    part.add<Tube>(sample_curve({at(92, -306.5, -13.1), at(104, -319.5, -15.4), at(117, -333.5, -17.8),
                                 at(128, -345, -19.9)},
                                {17.5, 16.0, 18.5, 20.0}, 4.0),
                   side(s, 0.73, 0.68, 0.0), 0.82)
        .cortex_mm = 1.5;
    // The greater trochanter, whose tip is level with the head, with its overhanging crest behind.
    rod({at(131, -342, -20), at(138, -326, -25), at(139, -312, -30)}, {17, 15, 9.5}, 1.0);
    rod({at(143, -334, -21), at(142, -350, -19)}, {12, 12}, 1.2);
    rod({at(137, -316, -33), at(128, -340, -36), at(119, -358, -34)}, {6.5, 5.5, 6.0}, 1.2);
    rod({at(124, -354, -26), at(113, -364, -32)}, {11, 7.0}, 1.2); // lesser trochanter
    // The wall of the femur's shaft thickens downwards to more than a third of the shaft's radius.
    const std::vector<Vec3> axis = {at(131, -338, -20), at(130.5, -362, -18), at(128, -395, -13),
                                    at(123, -450, -7)};
    rod(axis, {18, 17, 14.8, 14.2}, 2.0).marrow =
        std::make_shared<Tube>(sample_curve(axis, {16.8, 14.0, 9.4, 7.6}, 4.0));
    return part;
}

} // namespace

Solid femur_bones(const SkeletonShape &shape)
{
    Solid solid;
    for (double s : {-1.0, 1.0}) solid.add(femur_part(s, shape.sex == Sex::woman));
    return solid;
}

} // namespace anatomy
