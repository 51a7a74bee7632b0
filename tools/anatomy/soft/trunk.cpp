/* Makes the shape of the skin, of the fat under the skin, and of breasts. All figures are assumed. */
#include "tools/anatomy/organs.hpp"
#include <algorithm>
#include <cmath>

namespace anatomy
{

namespace
{

/* The table gives the half-width, front and back of the trunk at several heights, in millimetres. */
struct TrunkLevel {
    double y, half_width, front, back;
};

const TrunkLevel TRUNK[] = {
    {-470, 168, 78, -108},  {-400, 174, 88, -112},  {-340, 180, 96, -122},  {-290, 178, 100, -126},
    {-240, 170, 106, -116}, {-180, 158, 110, -108}, {-120, 150, 110, -107}, {-60, 152, 108, -114},
    {0, 158, 106, -123},    {60, 164, 108, -131},   {120, 170, 110, -136},  {170, 174, 106, -138},
    {215, 168, 92, -138},   {250, 142, 72, -132},   {280, 96, 52, -122},    {310, 66, 42, -108},
    {340, 60, 42, -98},     {400, 60, 44, -92},
};

double trunk_distance(const Vec3 &p)
{
    static const Spline width = course_over_height<Spline>(TRUNK, &TrunkLevel::half_width),
                        front = course_over_height<Spline>(TRUNK, &TrunkLevel::front),
                        back = course_over_height<Spline>(TRUNK, &TrunkLevel::back);
    const double a = width.at(p.y()), z_front = front.at(p.y()), z_back = back.at(p.y());
    const double b = 0.5 * (z_front - z_back), z = p.z() - 0.5 * (z_front + z_back);
    // The cross-section of the trunk is a superellipse, because a trunk is closer to a rectangle than an
    // ellipse is.
    // Its power is 2.5, which square roots give faster than pow() does.
    const double u = std::abs(p.x()) / a, w = std::abs(z) / b, root_u = std::sqrt(u), root_w = std::sqrt(w);
    const double level = std::pow(u * u * root_u + w * w * root_w, 0.4);
    if (level < 1e-6) return -std::min(a, b);
    const double scale = 1.0 / (level * std::sqrt(level));
    const double slope = scale * std::sqrt(std::pow(u * root_u / a, 2) + std::pow(w * root_w / b, 2));
    return (level - 1.0) / slope;
}

/* Returns 1 in an arm beside the body, and 0 in the trunk. */
double beside_share(const SoftShape &shape, const Vec3 &p)
{
    if (shape.arms == Arms::raised || p.y() > 190.0) return 0.0;
    return smooth_step(188.0, 222.0, std::abs(p.x())) * smooth_step(190.0, 120.0, p.y());
}

/* Where fat lies under the skin of the shipped man, at the chest 5 mm and at the belly and hips 14 mm; 2.5 mm
 * at neck, head and arms. A woman's hips and thighs have more. */
double fat_under_skin_mm(const SoftShape &shape, const Vec3 &p)
{
    constexpr double CHEST_FAT_MM = 5.0, BELLY_FAT_MM = 14.0, HEAD_FAT_MM = 2.5, HIPS_MM = 5.0;
    double fat = CHEST_FAT_MM + smooth_step(-110.0, 30.0, -p.y()) * (BELLY_FAT_MM - CHEST_FAT_MM);
    fat -= smooth_step(290.0, 360.0, p.y()) * (CHEST_FAT_MM - HEAD_FAT_MM);
    if (shape.sex == Sex::woman) fat += HIPS_MM * smooth_step(120.0, 230.0, -p.y());
    return std::lerp(fat, HEAD_FAT_MM, beside_share(shape, p));
}

/* Fat that a person has more or less than the shipped man lies in front and at the sides rather than at the
 * back. */
double extra_fat_mm(const SoftShape &shape, const Vec3 &p)
{
    if (shape.fat == 1.0) return 0.0;
    const double share = 0.6 + 0.4 * smooth_step(-110.0, 30.0, p.z());
    return (shape.fat - 1.0) * share * fat_under_skin_mm(shape, p);
}

/* The breasts of a person who lies on the back are flat and lean outwards. */
Part breasts(double radius_mm)
{
    Part part(8.0);
    for (double s : {-1.0, 1.0})
        part.add<Ellipsoid>(side(s, 82, 128, 88), Vec3(1.02, 1.05, 0.62) * radius_mm,
                            Eigen::AngleAxisd(s * 0.35, Vec3::UnitY()).toRotationMatrix());
    return part;
}

/* Neck, head, and raised arms that bend at the elbow over the head. They follow the bones
 * (skeleton/head.cpp). */
Part upper_parts()
{
    Part part(22.0);
    part.is_exact_inside = true;
    part.rod({{0, 300, -30}, {0, 350, -28}, {0, 395, -24}, {0, 440, -24}}, {60, 58, 58, 60});
    part.add<Ellipsoid>(Vec3(0, 489, -20), Vec3(78, 78, 99));
    part.add<Ellipsoid>(Vec3(0, 428, 30), Vec3(71, 74, 62));
    part.add<Ellipsoid>(Vec3(0, 384, 52), Vec3(42, 32, 36));
    part.rod({{0, 362, -10}, {0, 372, 40}}, {50, 34}); // under the jaw
    part.rod({{0, 448, 88}, {0, 426, 104}}, {7, 10});  // nose
    return part;
}

Part raised_arms()
{
    Part part(16.0);
    part.is_exact_inside = true;
    for (double s : {-1.0, 1.0}) {
        part.rod({side(s, 172, 240, -52), side(s, 206, 300, -42), side(s, 240, 390, -22),
                  side(s, 275, 470, -2), side(s, 300, 532, 12)},
                 {52, 48, 46, 41, 38});
        part.rod({side(s, 300, 535, 12), side(s, 262, 596, 18), side(s, 205, 668, 26), side(s, 158, 724, 34)},
                 {38, 42, 34, 27});
        Tube &hand =
            part.add<Tube>(sample_curve({side(s, 158, 724, 34), side(s, 130, 762, 38), side(s, 98, 800, 42)},
                                        {30, 40, 30}, 6.0),
                           side(s, 0.75, 0.6, 0), 0.42);
        hand.bounds.include(side(s, 130, 762, 38), 45.0);
    }
    return part;
}

Part lowered_arms()
{
    Part part(16.0);
    part.is_exact_inside = true;
    for (double s : {-1.0, 1.0}) {
        part.rod({side(s, 170, 228, -54), side(s, 194, 160, -54), side(s, 216, 90, -56), side(s, 238, 0, -60),
                  side(s, 254, -75, -62)},
                 {52, 50, 46, 42, 38});
        part.rod({side(s, 254, -75, -62), side(s, 262, -140, -58), side(s, 267, -240, -48),
                  side(s, 269, -326, -40)},
                 {38, 42, 34, 28});
        part.add<Tube>(
            sample_curve({side(s, 269, -320, -40), side(s, 269, -368, -38), side(s, 270, -430, -38)},
                         {30, 42, 36}, 6.0),
            Vec3::UnitX(), 0.42);
    }
    return part;
}

/* Returns the distance to a part, or FAR_MM where the part is too far to matter for the skin's surface. */
constexpr double FAR_MM = 1e3;

double distance_near(const Part &part, const Vec3 &p)
{
    constexpr double MATTERS_MM = 110.0; // more than the blends and the largest reach of a block of the grid
    return part.bounds.is_beyond(p, MATTERS_MM) ? FAR_MM : part.distance(p);
}

} // namespace

double belly_growth_mm(const SoftShape &shape, const Vec3 &p)
{
    if (shape.belly_mm == 0.0) return 0.0;
    const double along = smooth_step(-130.0, -10.0, -p.y()) * smooth_step(-300.0, -190.0, p.y());
    return shape.belly_mm * along * (1.0 - beside_share(shape, p)) *
           (0.25 + 0.75 * smooth_step(-90.0, 70.0, p.z()));
}

Solid breast_glands(const SoftShape &shape)
{
    Solid solid;
    if (shape.breast_mm > 0.0) solid.add(breasts(0.8 * shape.breast_mm));
    return solid;
}

Solid skin(const SoftShape &shape)
{
    constexpr double BOTTOM_MM = -430.0, RIM_MM = 6.0, SHOULDER_BLEND_MM = 45.0, NECK_BLEND_MM = 30.0,
                     BREAST_BLEND_MM = 30.0;
    Part shoulders(30.0);
    for (double s : {-1.0, 1.0}) shoulders.add<Ellipsoid>(side(s, 150, 232, -55), Vec3(60, 56, 58));
    const bool is_raised = shape.arms == Arms::raised;
    const Part limbs = is_raised ? raised_arms() : lowered_arms(), upper = upper_parts(),
               breast = breasts(shape.breast_mm);
    const double more_mm = std::max(0.0, 22.0 * (shape.fat - 1.0)) + std::max(0.0, shape.belly_mm) +
                           deepest_shift_mm(shape.bend);
    Box where;
    where.include(Vec3(-345 - more_mm, BOTTOM_MM, -160 - more_mm), 0.0);
    where.include(Vec3(345 + more_mm, is_raised ? 845 : 610, 150 + more_mm), 0.0);
    Part part(0.0);
    part.add<Formula>(
        [=](const Vec3 &p) {
            constexpr double NECK_MM = 330.0, NECK_RIM_MM = 20.0;
            double inside =
                smooth_max(trunk_distance(before_bend(shape.bend, p)), p.y() - NECK_MM, NECK_RIM_MM);
            if (const double limb = distance_near(limbs, p); limb < FAR_MM) {
                // Below the armpit, an arm beside the body only touches it.
                const double width_mm = is_raised
                                            ? SHOULDER_BLEND_MM
                                            : std::lerp(8.0, SHOULDER_BLEND_MM, smooth_step(90, 190, p.y()));
                inside = smooth_min(inside, smooth_min(shoulders.distance(p), limb, 40.0), width_mm);
            }
            inside = smooth_min(inside, distance_near(upper, p), NECK_BLEND_MM);
            inside -= extra_fat_mm(shape, p) + belly_growth_mm(shape, p);
            if (shape.breast_mm > 0.0) inside = smooth_min(inside, distance_near(breast, p), BREAST_BLEND_MM);
            // The next two lines of code cut out the gap between the thighs.
            const double gap = std::hypot(p.x() * 1.6, std::max(0.0, p.y() + 400.0)) - 26.0;
            inside = smooth_max(inside, -gap, 20.0);
            return smooth_max(inside, BOTTOM_MM - p.y(), RIM_MM);
        },
        where);
    Solid solid;
    solid.add(part);
    return solid;
}

double flesh_depth_mm(const SoftShape &shape, const Vec3 &p)
{
    // The flesh of all persons has the same outline, except for breasts and the belly's growth.
    constexpr double SKIN_MM = 2.4;
    double depth = SKIN_MM + fat_under_skin_mm(shape, p) + extra_fat_mm(shape, p);
    if (shape.breast_mm > 0.0) {
        // The whole breast lies in the fat, in front of the flesh.
        static constexpr double BREAST_DEPTH = 0.9;
        const Vec3 centre(p.x() < 0 ? -82 : 82, 128, 88);
        const double off = (p - centre).norm() / shape.breast_mm;
        depth += BREAST_DEPTH * 0.62 * shape.breast_mm * (1.0 - smooth_step(0.3, 1.5, off));
    }
    return depth;
}

} // namespace anatomy
