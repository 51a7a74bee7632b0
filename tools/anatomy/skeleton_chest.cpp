/* Makes the shapes of the ribs, sternum, clavicles, shoulder blades and heads of the humerus. All dimensions
 * of the chest's bones are assumed, for a chest that is 280 mm wide inside. */
#include "tools/anatomy/sheet.hpp"
#include "tools/anatomy/skeleton.hpp"
#include <cmath>

namespace anatomy
{

namespace
{

/* Holds the dimensions of one rib. The dimensions of a rib are the half-width of its loop, and the drop from
 * its head to its front end. Three more dimensions of a rib are the depth of its angle, the depth of its
 * widest point, and the position of its front end. */
struct RibShape {
    double half_width, fall, z_angle, z_side, front_x, front_z, height, angle_share;
};

const RibShape RIBS[12] = {
    {54, 36, -70, -28, 28, 30, 7.0, 0.62},     {82, 60, -90, -30, 34, 50, 6.6, 0.55},
    {101, 70, -101, -28, 43, 64, 6.4, 0.50},   {114, 78, -107, -26, 55, 72, 6.5, 0.47},
    {123, 86, -110, -25, 68, 75, 6.7, 0.45},   {130, 96, -112, -24, 82, 74, 6.9, 0.44},
    {135, 108, -112, -24, 98, 68, 7.0, 0.44},  {138, 117, -110, -25, 112, 55, 7.0, 0.45},
    {138, 118, -106, -28, 121, 36, 6.8, 0.46}, {134, 106, -102, -34, 126, 10, 6.6, 0.48},
    {122, 66, -97, -52, 117, -30, 5.8, 0.50},  {98, 44, -92, -74, 84, -70, 5.2, 0.55},
};

/* SIDE_FALL is the drop from a rib's head to the widest point of its loop, divided by the drop from the head
 * to the front end. */
constexpr double SIDE_FALL = 0.46;

Part rib_part(const RibShape &rib, const Vertebra &v, const Vertebra &above, double s)
{
    const double head_y = 0.5 * (v.centre_mm.y() + above.centre_mm.y()) - 3.0;
    const double back = v.centre_mm.z() - 0.5 * v.depth_mm;
    const double tubercle_x = 27.0;
    auto at = [&](double x, double fall_share, double z) {
        return side(s, x, head_y - fall_share * rib.fall, z);
    };
    const double angle_x = rib.angle_share * rib.half_width;
    std::vector<Vec3> points = {
        at(0.5 * v.width_mm + 5.0, 0.0, back + 5.0),
        at(tubercle_x, 0.03, std::max(back - 17.0, rib.z_angle + 9.0)),
        at(std::max(angle_x, tubercle_x + 10.0), 0.13, rib.z_angle),
        at(0.5 * (angle_x + rib.half_width) + 0.13 * rib.half_width, 0.28,
           rib.z_angle + 0.30 * (rib.z_side - rib.z_angle)),
        at(rib.half_width, SIDE_FALL, rib.z_side),
        at(rib.half_width - 0.22 * (rib.half_width - rib.front_x), 0.70,
           rib.z_side + 0.50 * (rib.front_z - rib.z_side)),
        at(rib.front_x + 0.22 * (rib.half_width - rib.front_x), 0.90,
           rib.z_side + 0.88 * (rib.front_z - rib.z_side)),
        at(rib.front_x, 1.0, rib.front_z),
    };
    const double h = rib.height;
    Part part(2.0);
    Tube &shaft = part.add<Tube>(
        sample_curve(points, {0.75 * h, 0.75 * h, 0.85 * h, 0.9 * h, h, h, 1.02 * h, 1.12 * h}, 5.0),
        Vec3(0.15 * s, 1.0, 0.1), 0.56);
    shaft.cortex_mm = 1.15;
    return part;
}

Part sternum_part()
{
    Part part(3.0);
    const Vec3 across = Vec3::UnitX();
    part.add<Tube>(sample_curve({{0, 246, 37}, {0, 232, 45}, {0, 208, 56}}, {31, 28, 19}, 4.0), across, 0.21)
        .cortex_mm = 1.1;
    part.add<Tube>(
            sample_curve({{0, 196, 61}, {0, 160, 72}, {0, 125, 79}, {0, 108, 80}}, {15, 18, 21, 13}, 4.0),
            across, 0.30)
        .cortex_mm = 1.1;
    part.rod({{0, 98, 80}, {0, 80, 80}}, {4, 2.5});
    return part;
}

/* Returns the shape of the shoulder blade from its medial border to its neck and lateral border, and from its
 * superior angle down to its inferior angle. */
Sheet blade(double s)
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
            rows[row].push_back({side(s, point.x(), point.y(), point.z()), 2.4 - 0.35 * middle});
        }
    return Sheet(rows);
}

/* Adds one shoulder. The arms are raised, so the shoulder blade is turned outwards and the humerus points
 * up. */
Part scapula_part(double s)
{
    Part part(4.0);
    const Vec3 glenoid = side(s, 146, 238, -62);
    part.add<Sheet>(blade(s)).cortex_mm = 1.0;
    part.rod({side(s, 84, 268, -104), side(s, 82, 238, -113), side(s, 85, 205, -118), side(s, 99, 162, -120),
              side(s, 116, 129, -118)},
             {2.6, 2.6, 2.6, 3.2, 4.2}, 1.1);
    part.rod(
        {side(s, 117, 129, -118), side(s, 138, 188, -97), side(s, 141, 210, -82), side(s, 143, 230, -68)},
        {4.2, 4.4, 4.6, 6.0}, 1.2);
    part.add<Ellipsoid>(glenoid, Vec3(7, 17, 11)).cortex_mm = 1.2;
    // The code below adds the spine of the scapula, up to the acromion, and the coracoid.
    part.plate(side(s, 90, 238, -112), side(s, 150, 262, -72), side(s, 128, 250, -112), 2.4);
    part.rod(
        {side(s, 92, 238, -122), side(s, 132, 258, -112), side(s, 162, 277, -78), side(s, 170, 280, -52)},
        {3, 5, 6, 5}, 1.2);
    part.rod({side(s, 136, 256, -60), side(s, 138, 264, -40), side(s, 148, 258, -26)}, {6, 6, 5}, 1.2);
    return part;
}

Part humerus_part(double s)
{
    Part part(6.0);
    part.add<Ellipsoid>(side(s, 173, 246, -52), Vec3(22.5, 22.5, 22.5)).cortex_mm = 1.3;
    part.rod({side(s, 176, 250, -51), side(s, 196, 270, -46)}, {20, 17}, 1.8);
    part.rod({side(s, 184, 256, -49), side(s, 206, 300, -40), side(s, 218, 336, -32), side(s, 226, 366, -26)},
             {18, 12.5, 11.5, 11}, 4.2);
    return part;
}

Part clavicle_part(double s)
{
    Part part(2.0);
    part.rod({side(s, 19, 247, 42), side(s, 45, 254, 40), side(s, 80, 263, 20), side(s, 115, 270, -15),
              side(s, 140, 276, -38), side(s, 158, 278, -46)},
             {10, 6.5, 5.6, 5.6, 6.0, 6.5}, 1.7);
    return part;
}

} // namespace

Solid rib_bones(const SkeletonShape &shape)
{
    constexpr size_t T1 = 3;
    const auto spine = vertebrae(shape);
    Solid solid;
    for (size_t i = 0; i < 12; i++)
        for (double s : {-1.0, 1.0})
            solid.add(rib_part(RIBS[i], spine[T1 + i], spine[T1 + i - (i < 10 ? 1 : 0)], s));
    solid.add(sternum_part());
    solid.enlarge(shape.scale);
    return solid;
}

Solid shoulder_bones(const SkeletonShape &shape)
{
    Solid solid;
    for (double s : {-1.0, 1.0}) {
        solid.add(scapula_part(s));
        solid.add(humerus_part(s));
        solid.add(clavicle_part(s));
    }
    solid.enlarge(shape.scale);
    return solid;
}

} // namespace anatomy
