/* The ribs, their cartilages, and the calcium in these. The bony lengths along the ribs are common figures
 * for a man; in a woman they are 0.89 times as long, with a stature of 0.93. The section of the sixth rib is
 * 12 to 14 mm by 6 to 8 mm, that of the first is flat, and the section of every rib twists by 60 to 90
 * degrees (common figures). The cortex is 0.9 to 2.6 mm thick, on average 1.4 mm inside the middle of the rib
 * (Holcombe 2019). The slope of the ribs and the courses, for a chest 280 mm wide inside, are assumed. */
#include "tools/anatomy/skeleton/levels.hpp"
#include <algorithm>
#include <cmath>

namespace anatomy
{

namespace
{

constexpr size_t RIBS = 12, CARTILAGES = 10, TRUE_RIBS = 7;

/* Holds the dimensions of one rib: the half-width of its loop, the drop from its head to the front end of its
 * course, the depths of its angle and of its widest point, the front end of its course, its bony length and
 * half of its height. */
struct RibShape {
    double half_width, fall, z_angle, z_side, front_x, front_z, length, height, angle_share;
};

const RibShape SHAPES[RIBS] = {
    {54, 38, -70, -28, 28, 30, 125, 8.0, 0.62},     {82, 64, -90, -30, 34, 50, 212, 6.4, 0.55},
    {101, 78, -101, -28, 43, 64, 262, 6.2, 0.50},   {114, 88, -107, -26, 55, 72, 290, 6.3, 0.47},
    {123, 97, -110, -25, 68, 75, 306, 6.5, 0.45},   {130, 108, -112, -24, 82, 74, 314, 6.6, 0.44},
    {135, 120, -112, -24, 98, 68, 315, 6.7, 0.44},  {138, 128, -110, -25, 112, 55, 305, 6.6, 0.45},
    {138, 126, -106, -28, 121, 36, 282, 6.4, 0.46}, {134, 110, -102, -34, 126, 10, 246, 6.2, 0.48},
    {122, 68, -97, -52, 117, -30, 188, 5.4, 0.50},  {98, 40, -92, -74, 84, -70, 112, 4.8, 0.55},
};

/* The places where the cartilages of the true ribs meet the sternum, on the left. */
const Vec3 STERNAL[TRUE_RIBS] = {{29, 233, 43}, {20, 201, 59}, {20, 180, 66}, {20, 160, 71},
                                 {22, 141, 75}, {20, 125, 77}, {15, 110, 78}};

/* SIDE_FALL is the drop from a rib's head to the widest point of its loop, divided by the drop from the head
 * to the front end. */
constexpr double SIDE_FALL = 0.46;

/* With age, the ribs slope less (PMC4111931, 339 CTs; the amount is assumed: 0.4 % of the drop in a year
 * beyond 60). The first three stay, because the arteries of the arms run beside them. */
double drop_mm(size_t rib, const SkeletonShape &shape)
{
    constexpr double FLATTER_PER_YEAR = 0.004, FROM_YEARS = 60.0;
    const double over = rib < 3 ? 0.0 : std::max(0.0, shape.age_years - FROM_YEARS);
    return SHAPES[rib].fall * (1.0 - FLATTER_PER_YEAR * over);
}

std::vector<Vec3> rib_course(const std::vector<Vertebra> &spine, size_t rib, double s,
                             const SkeletonShape &person)
{
    // The heads of ribs 2 to 10 lie on the discs above their vertebrae.
    const RibShape &shape = SHAPES[rib];
    const size_t index = T1 + rib;
    const Vertebra &v = spine[index], &above = rib > 0 && rib < 10 ? spine[index - 1] : v;
    const double fall = drop_mm(rib, person);
    const double head_y = 0.5 * (v.centre_mm.y() + above.centre_mm.y()) - 3.0;
    const Vec3 shift = spine_shift_mm(person.bend, head_y);
    const double back = v.centre_mm.z() - 0.5 * v.depth_mm;
    const double tubercle_x = std::max(22.0, 0.5 * levels()[index].transverse_span_mm - 3.0);
    const auto unbent = [&](double x, double share, double z) {
        return side(s, x, head_y - share * fall, z);
    };
    const auto at = [&](double x, double share, double z) {
        return moved_with_spine(person.bend, unbent(x, share, z));
    };
    const Vec3 aside(shift.x(), 0.0, 0.0); // of the joints with the vertebra
    const double angle_x = std::max(shape.angle_share * shape.half_width, tubercle_x + 10.0);
    const double side_to_front = shape.half_width - shape.front_x;
    return {
        unbent(0.5 * v.width_mm + 4.0, 0.0, back + 5.0) + aside,
        unbent(tubercle_x, 0.03, std::max(back - 15.0, shape.z_angle + 9.0 + shift.z())) + aside,
        at(angle_x, 0.13, shape.z_angle),
        at(0.5 * (angle_x + shape.half_width) + 0.13 * shape.half_width, 0.28,
           shape.z_angle + 0.30 * (shape.z_side - shape.z_angle)),
        at(shape.half_width, SIDE_FALL, shape.z_side),
        at(shape.half_width - 0.22 * side_to_front, 0.70,
           shape.z_side + 0.50 * (shape.front_z - shape.z_side)),
        at(shape.front_x + 0.22 * side_to_front, 0.90, shape.z_side + 0.88 * (shape.front_z - shape.z_side)),
        at(shape.front_x, 1.0, shape.front_z),
    };
}

/* Returns the course of the bony rib, with half of its height at every point. */
Curve rib_curve(const std::vector<Vertebra> &spine, size_t rib, double s, const SkeletonShape &shape)
{
    const double h = SHAPES[rib].height;
    Curve curve = sample_curve(rib_course(spine, rib, s, shape),
                               {0.72 * h, 0.72 * h, 0.85 * h, 0.9 * h, h, h, 1.02 * h, 1.12 * h}, 5.0);
    const double length_mm = SHAPES[rib].length * (shape.sex == Sex::woman ? 0.89 / 0.93 : 1.0);
    while (curve.size() > 3 && curve.back().arc_mm > length_mm) curve.pop_back();
    return curve;
}

/* Returns the sections along a rib. Its height leans outwards at the back, where the outer face looks down a
 * little, and inwards in front. The first rib lies flat, and the second is on its way to it. */
std::vector<Tube::Section> rib_sections(const Curve &curve, size_t rib, double s)
{
    const double flatness = rib == 0 ? 6.0 : rib == 1 ? 0.9 : rib == 2 ? 0.35 : 0.0;
    const double thin = rib == 0 ? 0.32 : rib == 1 ? 0.48 : 0.52;
    std::vector<Tube::Section> sections;
    for (size_t i = 0; i < curve.size(); i++) {
        const double share = curve[i].arc_mm / curve.back().arc_mm;
        const Vec3 outwards = s * Vec3::UnitY().cross(curve_tangent(curve, i));
        const double lean = 0.45 - 1.0 * share - flatness;
        const double neck = smooth_step(0.16, 0.03, share); // the neck is rounder
        sections.push_back({(Vec3::UnitY() + lean * outwards).normalized(), thin + (0.75 - thin) * neck});
    }
    return sections;
}

Part rib_part(const std::vector<Vertebra> &spine, size_t rib, double s, const SkeletonShape &shape)
{
    const Curve curve = rib_curve(spine, rib, s, shape);
    Part part(2.0);
    part.add<Tube>(curve, rib_sections(curve, rib, s)).cortex_mm = 1.15;
    // Head and tubercle: the joints with the bodies and with the transverse process.
    const std::vector<Vec3> course = rib_course(spine, rib, s, shape);
    part.add<Ellipsoid>(course[0] + side(s, -0.5, 0, 0), Vec3(5.0, 5.5, 5.0)).cortex_mm = 0.9;
    if (rib < 10) part.add<Ellipsoid>(course[1] + Vec3(0, 0, -2.0), Vec3(5.0, 4.6, 4.2)).cortex_mm = 0.9;
    return part;
}

/* Returns the course of a cartilage from the end of its rib to the sternum, or to the cartilage above. */
Curve cartilage_curve(const std::vector<Vertebra> &spine, size_t rib, double s, const SkeletonShape &shape)
{
    const Curve bone = rib_curve(spine, rib, s, shape);
    const Vec3 start = bone.back().position_mm, ahead = curve_tangent(bone, bone.size() - 1);
    Vec3 end;
    if (rib < TRUE_RIBS) {
        end = side(s, STERNAL[rib].x(), STERNAL[rib].y(), STERNAL[rib].z());
    } else {
        const Curve above = cartilage_curve(spine, rib - 1, s, shape);
        end = above[above.size() * (rib == TRUE_RIBS ? 5 : 4) / 10].position_mm - Vec3(0, 11, 0);
    }
    const Vec3 bend = start + 0.42 * (end - start).norm() * ahead;
    const Vec3 middle = 0.3 * start + 0.45 * bend + 0.25 * end;
    const double half_mm = SHAPES[rib].height;
    return sample_curve({start + 2.5 * ahead, middle, end},
                        {rib == 0 ? 7.0 : 1.05 * half_mm, half_mm, 0.75 * half_mm}, 5.0);
}

/* The height of a cartilage's section stands upright in the plane of the chest's wall. */
Vec3 cartilage_height(const Curve &curve, size_t index, double s)
{
    const Vec3 along = curve_tangent(curve, index), outwards = (Vec3::UnitZ() + 0.5 * s * Vec3::UnitX());
    return outwards.cross(along).normalized();
}

/* The calcium of a man lies along the upper and lower edges of the cartilages, that of a woman in tongues in
 * their middle; it grows from the rib towards the sternum, and the first cartilage has most. */
Part calcium_part(const Curve &cartilage, size_t rib, double s, const SkeletonShape &shape)
{
    constexpr double EDGE = 0.72, ROD_MM = 1.4, TONGUE_MM = 2.0;
    Part part(1.0);
    const bool man = shape.sex == Sex::man;
    for (double edge : man ? std::vector<double>{-1.0, 1.0} : std::vector<double>{0.0}) {
        // The rods of neighbouring edges and ribs end at different places (assumed).
        const double uneven = 1.0 + 0.35 * std::sin(2.4 * static_cast<double>(rib) + 1.7 * edge + s);
        const double share = std::min(1.0, shape.cartilage_calcium * uneven * (rib == 0 ? 3.0 : 1.0));
        std::vector<Vec3> points;
        std::vector<double> radii;
        for (size_t i = 0; i < cartilage.size(); i++) {
            if (cartilage[i].arc_mm > share * cartilage.back().arc_mm) break;
            points.push_back(cartilage[i].position_mm +
                             edge * EDGE * cartilage[i].radius_mm * cartilage_height(cartilage, i, s));
            radii.push_back((man ? ROD_MM : TONGUE_MM) *
                            (1.0 + 0.3 * std::sin(1.9 * static_cast<double>(i) + edge)));
        }
        if (points.size() >= 2) part.rod(points, radii);
    }
    return part;
}

} // namespace

Solid rib_bones(const SkeletonShape &shape)
{
    const auto spine = vertebrae(shape);
    Solid solid;
    for (size_t rib = 0; rib < RIBS; rib++)
        for (double s : {-1.0, 1.0}) solid.add(rib_part(spine, rib, s, shape));
    solid.add(sternum_part());
    return solid;
}

Solid costal_cartilages(const SkeletonShape &shape)
{
    const auto spine = vertebrae(shape);
    Solid solid;
    for (size_t rib = 0; rib < CARTILAGES; rib++)
        for (double s : {-1.0, 1.0}) {
            const Curve curve = cartilage_curve(spine, rib, s, shape);
            std::vector<Tube::Section> sections;
            for (size_t i = 0; i < curve.size(); i++)
                sections.push_back({cartilage_height(curve, i, s), 0.62});
            Part part(0.0);
            part.add<Tube>(curve, sections);
            solid.add(part);
        }
    return solid;
}

Solid cartilage_calcium(const SkeletonShape &shape)
{
    const auto spine = vertebrae(shape);
    Solid solid;
    for (size_t rib = 0; rib < CARTILAGES; rib++)
        for (double s : {-1.0, 1.0}) {
            Part part = calcium_part(cartilage_curve(spine, rib, s, shape), rib, s, shape);
            if (!part.added.empty()) solid.add(part);
        }
    return solid;
}

} // namespace anatomy
