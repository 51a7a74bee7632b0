/* Makes the shape of the skin and of the fat under the skin. */
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
    static const auto spline = [](double TrunkLevel::*field) {
        std::vector<double> y, value;
        for (const TrunkLevel &level : TRUNK) {
            y.push_back(level.y);
            value.push_back(level.*field);
        }
        return Spline(y, value);
    };
    static const Spline width = spline(&TrunkLevel::half_width), front = spline(&TrunkLevel::front),
                        back = spline(&TrunkLevel::back);
    const double a = width.at(p.y()), z_front = front.at(p.y()), z_back = back.at(p.y());
    const double b = 0.5 * (z_front - z_back), z = p.z() - 0.5 * (z_front + z_back);
    // The cross-section of the trunk is a superellipse, because a trunk is closer to a rectangle than an
    // ellipse is.
    constexpr double POWER = 2.5;
    const double u = std::abs(p.x()) / a, w = std::abs(z) / b;
    const double level = std::pow(std::pow(u, POWER) + std::pow(w, POWER), 1.0 / POWER);
    if (level < 1e-6) return -std::min(a, b);
    const double scale = std::pow(level, 1.0 - POWER);
    const double slope =
        std::hypot(scale * std::pow(u, POWER - 1.0) / a, scale * std::pow(w, POWER - 1.0) / b);
    return (level - 1.0) / slope;
}

} // namespace

Solid skin()
{
    constexpr double BOTTOM_MM = -430.0, SKIN_TOP_MM = 352.0, RIM_MM = 6.0, SHOULDER_BLEND_MM = 45.0;
    Part shoulders(30.0);
    for (double s : {-1.0, 1.0}) {
        shoulders.add<Ellipsoid>(side(s, 150, 232, -55), Vec3(60, 56, 58));
        shoulders.rod({side(s, 172, 240, -52), side(s, 206, 300, -42), side(s, 226, 360, -30)}, {52, 47, 44});
    }
    Box where;
    where.include(Vec3(-290, BOTTOM_MM, -160), 0.0);
    where.include(Vec3(290, SKIN_TOP_MM, 130), 0.0);
    Part part(0.0);
    part.add<Formula>(
        [shoulders](const Vec3 &p) {
            double inside = smooth_min(trunk_distance(p), shoulders.distance(p), SHOULDER_BLEND_MM);
            // The next two lines of code cut out the gap between the thighs.
            const double gap = std::hypot(p.x() * 1.6, std::max(0.0, p.y() + 400.0)) - 26.0;
            inside = smooth_max(inside, -gap, 20.0);
            return smooth_max(inside, std::max(BOTTOM_MM - p.y(), p.y() - SKIN_TOP_MM), RIM_MM);
        },
        where);
    Solid solid;
    solid.add(part);
    return solid;
}

double flesh_depth_mm(const Vec3 &p)
{
    // The fat under the skin is thin over the chest and thicker over the belly and hips.
    constexpr double SKIN_MM = 2.0, CHEST_FAT_MM = 5.0, BELLY_FAT_MM = 14.0, FROM_MM = 110.0, TO_MM = -30.0;
    const double share = std::clamp((FROM_MM - p.y()) / (FROM_MM - TO_MM), 0.0, 1.0);
    const double smooth = share * share * (3.0 - 2.0 * share);
    return SKIN_MM + CHEST_FAT_MM + smooth * (BELLY_FAT_MM - CHEST_FAT_MM);
}

} // namespace anatomy
