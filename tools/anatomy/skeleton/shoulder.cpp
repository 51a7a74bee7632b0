/* Makes the shapes of the clavicles, shoulder blades and upper arms. Their dimensions are assumed.
 */
#include "tools/anatomy/sheet.hpp"
#include "tools/anatomy/skeleton.hpp"
#include <cmath>

namespace anatomy
{

namespace
{

/* Returns a point of the shoulder blade, which is stated for raised arms. Beside the body, the blade is
 * turned down by 20 degrees about its middle. It lies on the ribs, and moves with them. */
Vec3 blade_point(double s, const SkeletonShape &shape, double x, double y, double z)
{
    constexpr double MIDDLE_X = 105.0, MIDDLE_Y = 235.0, COSINE = 0.940, SINE = 0.342;
    if (shape.arms == Arms::raised) return moved_with_spine(shape.bend, side(s, x, y, z));
    const double across = x - MIDDLE_X, up = y - MIDDLE_Y;
    return moved_with_spine(shape.bend, side(s, MIDDLE_X + COSINE * across + SINE * up,
                                             MIDDLE_Y - SINE * across + COSINE * up, z));
}

/* Returns the shape of the shoulder blade from its medial border to its neck and lateral border, and from its
 * superior angle down to its inferior angle. */
Sheet blade(double s, const SkeletonShape &shape)
{
    constexpr size_t DOWN = 55, ACROSS = 25;
    const auto medial = evenly_along(
        {{84, 268, -104}, {82, 238, -113}, {85, 205, -118}, {99, 162, -120}, {115, 129, -118}}, DOWN);
    const auto lateral = evenly_along(
        {{134, 257, -70}, {143, 236, -66}, {141, 210, -82}, {138, 188, -97}, {122, 133, -117}}, DOWN);
    std::vector<std::vector<SheetPoint>> rows(DOWN);
    for (size_t row = 0; row < DOWN; row++)
        for (size_t i = 0; i < ACROSS; i++) {
            const double share = static_cast<double>(i) / (ACROSS - 1), middle = 4.0 * share * (1.0 - share);
            const double width_mm = (lateral[row] - medial[row]).norm();
            // The shoulder blade is concave on the side of the ribs and thin in the middle.
            const Vec3 point =
                medial[row] + share * (lateral[row] - medial[row]) - 0.1 * middle * width_mm * Vec3::UnitZ();
            rows[row].push_back(
                {blade_point(s, shape, point.x(), point.y(), point.z()), 2.4 - 0.35 * middle});
        }
    return Sheet(rows);
}

/* Adds one shoulder blade, which is turned outwards where the arms are raised. */
Part scapula_part(double s, const SkeletonShape &shape)
{
    const auto at = [&](double x, double y, double z) { return blade_point(s, shape, x, y, z); };
    Part part(4.0);
    const Vec3 glenoid = at(146, 238, -62);
    part.add<Sheet>(blade(s, shape)).cortex_mm = 0.9;
    part.rod({at(84, 268, -104), at(82, 238, -113), at(85, 205, -118), at(99, 162, -120), at(116, 129, -118)},
             {2.4, 2.6, 2.4, 3.0, 4.2}, 1.0);
    part.rod({at(117, 129, -118), at(138, 188, -97), at(141, 210, -82), at(143, 230, -68)},
             {4.2, 4.0, 4.6, 6.0}, 1.2);
    part.add<Ellipsoid>(glenoid, Vec3(6, 18, 12)).cortex_mm = 1.1;
    part.rod({at(143, 239, -64), at(130, 240, -78)}, {9, 5}, 1.0); // neck
    // The spine of the shoulder blade stands up and back from it, and ends as the flat acromion.
    part.plate(at(88, 240, -113), at(140, 250, -80), at(126, 264, -108), Vec3(1.4, 2.4, 1.8), 0.9);
    part.rod({at(90, 241, -117), at(110, 256, -114), at(128, 266, -109)}, {2.2, 3.2, 4.2}, 1.0);
    part.add<Tube>(sample_curve({at(126, 265, -109), at(146, 275, -98), at(163, 281, -78), at(167, 282, -57)},
                                {4.6, 8.0, 11.5, 9.0}, 4.0),
                   side(s, 0.8, 0.1, -0.6), 0.42)
        .cortex_mm = 1.0;
    part.rod({at(137, 250, -66), at(136, 264, -50), at(143, 263, -34), at(150, 257, -26)}, {8, 6.5, 6, 5},
             1.1); // coracoid
    return part;
}

/* The humerus of a raised arm points up. */
Part raised_humerus(double s)
{
    Part part(6.0);
    part.is_exact_inside = true; // the marrow of the shaft lies deep
    part.add<Ellipsoid>(side(s, 173, 246, -52), Vec3(22.5, 22.5, 22.5)).cortex_mm = 1.3;
    part.rod({side(s, 176, 250, -51), side(s, 196, 270, -46)}, {20, 17}, 1.8);
    part.rod({side(s, 184, 256, -49), side(s, 206, 300, -40), side(s, 240, 388, -22), side(s, 276, 474, -3),
              side(s, 296, 524, 8)},
             {18, 12.5, 11, 11, 12}, 4.2);
    part.rod({side(s, 282, 540, 20), side(s, 308, 528, 2)}, {11, 12}, 1.4); // trochlea and capitulum
    return part;
}

/* Beside the body, the arm leans outwards by 13 degrees. */
Part lowered_humerus(double s)
{
    Part part(6.0);
    part.is_exact_inside = true;
    part.add<Ellipsoid>(side(s, 171, 227, -53), Vec3(22.5, 22.5, 22.5)).cortex_mm = 1.3;
    part.rod({side(s, 175, 222, -53), side(s, 186, 202, -53)}, {20, 17}, 1.8);
    part.rod({side(s, 182, 210, -53), side(s, 196, 160, -53), side(s, 216, 90, -56), side(s, 238, 0, -60),
              side(s, 252, -58, -60)},
             {18, 12.5, 11, 11, 12}, 4.2);
    for (const double end : {240.0, 270.0}) // the epicondyles
        part.rod({side(s, 252, -34, -60), side(s, 0.5 * (252 + end), -54, -60), side(s, end, -68, -60)},
                 {10.5, 9.0, 7.0}, 1.6);
    part.rod({side(s, 243, -74, -58), side(s, 254, -73, -58), side(s, 266, -75, -56)}, {9.5, 7.5, 9.5}, 1.4);
    return part;
}

/* The clavicle is thick and round at the sternum and flat at its outer end. */
Part clavicle_part(double s, Arms arms)
{
    const double low = arms == Arms::beside ? 1.0 : 0.0; // its outer end lies lower beside a lowered arm
    const Curve curve =
        sample_curve({side(s, 19, 247, 42), side(s, 28, 250, 43), side(s, 48, 255, 39),
                      side(s, 80, 263 - low, 20), side(s, 115, 271 - 5 * low, -15),
                      side(s, 140, 277 - 13 * low, -38), side(s, 157 + 3 * low, 279 - 19 * low, -47)},
                     {11, 10, 7.0, 6.0, 6.2, 8.0, 8.5}, 4.0);
    std::vector<Tube::Section> sections;
    for (const CurvePoint &point : curve) {
        const double outer = smooth_step(0.5, 1.0, point.arc_mm / curve.back().arc_mm);
        sections.push_back({Vec3(0.3 * s, 0.0, 1.0).normalized(), 0.95 - 0.4 * outer});
    }
    Part part(2.0);
    part.add<Tube>(curve, sections).cortex_mm = 1.6;
    return part;
}

} // namespace

Solid shoulder_bones(const SkeletonShape &shape)
{
    Solid solid;
    for (double s : {-1.0, 1.0}) {
        solid.add(scapula_part(s, shape));
        solid.add(shape.arms == Arms::raised ? raised_humerus(s) : lowered_humerus(s));
        solid.add(clavicle_part(s, shape.arms));
    }
    return solid;
}

} // namespace anatomy
