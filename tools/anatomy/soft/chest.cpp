/* Makes the shapes of the lungs, the heart, the mediastinum and the airway. */
#include "tools/anatomy/organs.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace anatomy
{

namespace
{

/* The table gives the half-width, front and back of the chest cavity at several heights, in millimetres. */
struct ChestLevel {
    double y, half_width, front, back;
};

const ChestLevel CAVITY[] = {
    {-60, 116, 0, -86},  {-20, 126, 24, -93},  {0, 129, 36, -96},    {40, 130, 54, -101},
    {80, 129, 64, -104}, {120, 125, 66, -105}, {160, 116, 60, -104}, {200, 101, 46, -100},
    {225, 88, 33, -96},  {250, 67, 16, -88},   {270, 48, 2, -78},    {286, 30, -14, -66},
    {300, 14, -28, -56}, {320, 8, -34, -50},
};

constexpr double APEX_MM = 291.0;

double cavity_distance(const Vec3 &p)
{
    static const Spline width = course_over_height<Spline>(CAVITY, &ChestLevel::half_width),
                        front = course_over_height<Spline>(CAVITY, &ChestLevel::front),
                        back = course_over_height<Spline>(CAVITY, &ChestLevel::back);
    const double a = width.at(p.y()), z_front = front.at(p.y()), z_back = back.at(p.y());
    const double b = 0.5 * (z_front - z_back);
    const double outline = ellipsoid_distance({p.x(), 0.0, p.z() - 0.5 * (z_front + z_back)}, {a, 1e3, b});
    return smooth_max(outline, p.y() - APEX_MM, 12.0);
}

/* Returns the height of the diaphragm at a given position in the horizontal plane. The diaphragm is a dome
 * whose edge is lower at the side, and lowest at the back. */
double dome_mm(double sign, double x, double z)
{
    const double peak = sign < 0 ? 77.0 : 65.0, out = (sign * x - 62.0) / 64.0, along = (z - 8.0) / 100.0;
    const double side_fall = out > 0 ? 74.0 * std::pow(out, 2.6) : 12.0 * out * out;
    const double depth_fall = along < 0 ? 88.0 * std::pow(-along, 2.2) : 34.0 * along * along;
    return peak - side_fall - depth_fall;
}

} // namespace

Box lung_bounds(double sign, const SpineBend &bend)
{
    const double deeper_mm = deepest_shift_mm(bend);
    Box box;
    box.include(side(sign, 2, -75, -110 - deeper_mm), 0.0);
    box.include(side(sign, 134, APEX_MM, 72), 0.0);
    return box;
}

Distance lung_cavity(double sign, const SpineBend &bend)
{
    return [=](const Vec3 &p) {
        constexpr double STEEPNESS =
            0.55; // converts the difference in height to an approximate distance at the steep edge
        const double above = (dome_mm(sign, p.x(), p.z()) - p.y()) * STEEPNESS;
        const double own_side = 1.8 - sign * p.x();
        return smooth_max(smooth_max(cavity_distance(before_bend(bend, p)), above, 4.0), own_side, 3.0);
    };
}

namespace
{

/* Returns the rotation that turns +x to `direction`, which must not be -x. */
Eigen::Matrix3d axis_to(const Vec3 &direction)
{
    // The returned rotation is the shortest rotation from +x to `direction`. Eigen's function FromTwoVectors
    // is not used here. Eigen's function FromTwoVectors contains a singular value decomposition for the
    // direction -x, and this decomposition takes 8 s to compile.
    const Vec3 to = direction.normalized();
    const double w = std::sqrt(2.0 * (1.0 + to.x())); // twice the cosine of half the angle
    const Vec3 axis = Vec3(0.0, -to.z(), to.y()) / w;
    return Eigen::Quaterniond(0.5 * w, axis.x(), axis.y(), axis.z()).toRotationMatrix();
}

/* Returns the ventricles, atria and outflow tract as one shape, whose outline lies wall_mm inside the heart's
 * outline. */
Part heart_part(double wall_mm)
{
    Part part(18.0);
    const Vec3 w = Vec3::Constant(wall_mm);
    part.add<Ellipsoid>(Vec3(40, 93, 24), Vec3(54, 38, 36) - w, axis_to({0.74, -0.46, 0.48}));
    part.add<Ellipsoid>(Vec3(12, 87, 36), Vec3(48, 34, 29) - w, axis_to({0.9, -0.35, 0.2}));
    part.add<Ellipsoid>(Vec3(-20, 106, 12), Vec3(27, 38, 30) - w);
    part.add<Ellipsoid>(Vec3(8, 128, -18), Vec3(37, 24, 22) - w);
    part.add<Ellipsoid>(Vec3(22, 148, 34), Vec3(18, 30, 17) - w, axis_to({1, 0.15, -0.2}));
    return part;
}

} // namespace

Solid heart_outline()
{
    constexpr double PERICARDIUM_MM = 1.5;
    Solid solid;
    solid.add(heart_part(PERICARDIUM_MM));
    return solid;
}

std::vector<Chamber> heart_chambers()
{
    constexpr double LEFT_WALL_MM = 10.0, THIN_WALL_MM = 2.5;
    Part left(0.0), right(8.0), right_atrium(0.0), left_atrium(0.0);
    left.add<Ellipsoid>(Vec3(38, 94, 22), Vec3(42, 23, 22), axis_to({0.74, -0.46, 0.48}));
    right.add<Ellipsoid>(Vec3(12, 87, 36), Vec3(44, 30, 25), axis_to({0.9, -0.35, 0.2}));
    right.add<Ellipsoid>(Vec3(20, 140, 34), Vec3(14, 28, 13), axis_to({1, 0.15, -0.2}));
    right_atrium.add<Ellipsoid>(Vec3(-20, 106, 12), Vec3(24, 35, 27));
    left_atrium.add<Ellipsoid>(Vec3(8, 128, -18), Vec3(34, 21, 19));
    const Distance left_ventricle = [left](const Vec3 &p) { return left.distance(p); };
    const Distance right_ventricle = [=](const Vec3 &p) {
        return smooth_max(right.distance(p), LEFT_WALL_MM - left_ventricle(p), 3.0);
    };
    // An atrium ends at the valve, where its ventricle begins.
    const Distance right_side = [=](const Vec3 &p) {
        const double taken = std::min(right.distance(p) - THIN_WALL_MM, left_ventricle(p) - LEFT_WALL_MM);
        return smooth_max(right_atrium.distance(p), -taken, 3.0);
    };
    const Distance left_side = [=](const Vec3 &p) {
        const double taken = std::min({right.distance(p) - THIN_WALL_MM, left_ventricle(p) - THIN_WALL_MM,
                                       right_atrium.distance(p) - THIN_WALL_MM});
        return smooth_max(left_atrium.distance(p), -taken, 3.0);
    };
    const auto around = [](const Part &part) {
        Box box = part.bounds;
        box.include(part.bounds.low, 3.0);
        box.include(part.bounds.high, 3.0);
        return box;
    };
    return {{"left_ventricle", left_ventricle, around(left)},
            {"right_ventricle", right_ventricle, around(right)},
            {"right_atrium", right_side, around(right_atrium)},
            {"left_atrium", left_side, around(left_atrium)}};
}

Solid mediastinum(const SpineBend &bend)
{
    const auto moved = [&](std::vector<Vec3> points) {
        for (Vec3 &point : points) point = moved_with_spine(bend, point);
        return points;
    };
    Solid solid;
    solid.add(heart_part(0.0));
    Part middle(10.0);
    // The mediastinum is a column in front of the spine that thins to a septum behind the sternum.
    middle.add<Tube>(
        sample_curve(moved({{0, 60, -38}, {0, 130, -42}, {0, 190, -30}, {0, 250, -18}, {0, 300, -18}}),
                     {24, 22, 20, 22, 24}, 6.0));
    middle.plate({0, 80, -60}, {0, 80, 66}, {0, 250, -60}, 1.2);
    middle.plate({0, 80, 66}, {0, 250, -60}, {0, 250, 34}, 1.2);
    // The back muscles fill the space behind the spine, so that the lungs stay beside the vertebrae.
    middle.add<Tube>(
        sample_curve(moved({{0, -40, -76}, {0, 60, -97}, {0, 150, -108}, {0, 220, -99}, {0, 300, -78}}),
                     {26, 27, 27, 26, 26}, 6.0));
    // The code below adds the superior vena cava with the right brachiocephalic vein, the inferior vena cava,
    // the pulmonary trunk and the hila.
    middle.rod({{-30, 112, 8}, {-29, 160, 10}, {-27, 215, 12}, {-32, 252, 12}}, {13, 11, 10, 9});
    middle.rod({{-22, 60, -4}, {-22, 100, 2}}, {14, 14});
    middle.rod({{20, 150, 32}, {28, 172, 16}, {34, 176, -14}}, {14, 14, 12});
    middle.rod({{0, 172, -8}, {-34, 170, -12}}, {11, 9});
    solid.add(middle);
    Part hila(5.0);
    for (double s : {-1.0, 1.0}) {
        const double up = s > 0 ? 8.0 : 0.0;
        hila.rod({side(s, 30, 170 + up, -14), side(s, 44, 160 + up, -18), side(s, 50, 142 + up, -24)},
                 {10, 9, 6});
        hila.rod({side(s, 32, 172 + up, -12), side(s, 46, 180 + up, -8)}, {9, 5});
        hila.rod({side(s, 26, 140, -18), side(s, 44, 136, -20)}, {9, 5});
    }
    solid.add(hila);
    return solid;
}

Solid airway()
{
    Part part(4.0);
    part.rod({{0, 428, 22}, {0, 408, 12}, {0, 380, 4}, {0, 352, 6}, {-1, 326, 0}}, {7, 7, 9, 6.5, 8.5});
    part.rod({{-1, 326, 0}, {-2, 300, -8}, {-5, 250, -20}, {-6, 205, -29}}, {8.5, 8.5, 8.8, 9.0});
    part.rod({{-6, 206, -29}, {-20, 192, -28}, {-33, 180, -27}}, {7.5, 7.0, 6.0});
    part.rod({{-6, 205, -29}, {14, 190, -29}, {34, 179, -28}}, {7.0, 6.0, 5.5});
    Solid solid;
    solid.add(part);
    return solid;
}

} // namespace anatomy
