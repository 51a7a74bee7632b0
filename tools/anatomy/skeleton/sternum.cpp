/* The shape of the sternum: manubrium 50 by 60 mm, body 102 mm long, 10 to 15 mm thick (common figures for a
 * man); its place, outline and slope are assumed. */
#include "tools/anatomy/skeleton/levels.hpp"
#include <algorithm>
#include <cmath>

namespace anatomy
{

namespace
{

/* Holds the sternum at one height: half of its width and thickness, and the depth of its middle. */
struct SternumLevel {
    double y, half_width, half_thickness, z;
};

const SternumLevel STERNUM[] = {
    {70, 2.5, 1.8, 79},     {84, 5.0, 2.2, 80},     {98, 8.0, 3.0, 80},     {106, 15.0, 4.4, 79.5},
    {118, 20.5, 5.0, 78},   {132, 20.0, 5.2, 75.5}, {150, 18.0, 5.3, 71},   {170, 16.0, 5.2, 67},
    {188, 14.5, 5.0, 64.5}, {198, 17.0, 4.8, 62.5}, {206, 17.0, 4.9, 59.5}, {216, 21.0, 5.2, 55.5},
    {226, 28.0, 5.6, 50.5}, {236, 30.5, 6.2, 45},   {243, 25.0, 6.2, 40.5}, {250, 14.0, 6.0, 35},
};
constexpr double STERNUM_TOP_MM = 247.0, STERNUM_LOW_MM = 74.0, ANGLE_MM = 202.0, XIPHOID_MM = 101.0;

constexpr double SLOPE = 0.88; // a sternum that slopes by 28 degrees is that much thinner than deep

SternumLevel level_at(double y)
{
    static const MonotoneCubic width = course_over_height<MonotoneCubic>(STERNUM, &SternumLevel::half_width),
                               thickness =
                                   course_over_height<MonotoneCubic>(STERNUM, &SternumLevel::half_thickness),
                               depth = course_over_height<MonotoneCubic>(STERNUM, &SternumLevel::z);
    return {y, width.at(y), thickness.at(y), depth.at(y)};
}

double sternum_distance(const Vec3 &p)
{
    constexpr double JOINT_MM = 1.4;                       // half of the gap of the manubriosternal joint
    constexpr double NOTCH_MM = 6.0, NOTCH_HALF_MM = 14.0; // the jugular notch
    const SternumLevel level = level_at(p.y());
    const double across = std::abs(p.x()) - level.half_width;
    const double along = SLOPE * std::abs(p.z() - level.z) - level.half_thickness;
    const double notch = NOTCH_MM * std::max(0.0, 1.0 - p.x() * p.x() / (NOTCH_HALF_MM * NOTCH_HALF_MM));
    const double ends = std::max(p.y() - STERNUM_TOP_MM + notch, STERNUM_LOW_MM - p.y());
    const double joint = JOINT_MM - std::abs(p.y() - ANGLE_MM);
    const double outline = smooth_max(smooth_max(across, along, 7.0), ends, 4.0);
    return smooth_max(smooth_max(outline, joint, 2.0), JOINT_MM - std::abs(p.y() - XIPHOID_MM), 2.0);
}

} // namespace

SternumSection sternum_section(double y_mm)
{
    const SternumLevel level = level_at(y_mm);
    return {level.half_width, level.half_thickness / SLOPE, level.z};
}

Part sternum_part()
{
    Box where;
    where.include(Vec3(-32, STERNUM_LOW_MM, 26), 0.0);
    where.include(Vec3(32, STERNUM_TOP_MM, 88), 0.0);
    Part part(0.0);
    part.add<Formula>(sternum_distance, where).cortex_mm = 1.0;
    return part;
}

} // namespace anatomy
