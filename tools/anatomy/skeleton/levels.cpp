/* The measures of the levels of the spine, and the places of the vertebrae. "Panjabi" stands for Panjabi and
 * others, Spine 1991;16:888 and 861 and 1992;17:299, whose specimens were small. */
#include "tools/anatomy/skeleton/levels.hpp"
#include "tools/anatomy/skeleton/spine_bend.hpp"
#include <cmath>

namespace anatomy
{

namespace
{

/* Heights, widths and depths of the bodies and the discs are rounded from published measurements: lumbar
 * heights near Gilad and Nissan 1985, J Anat 143:115, thoracic discs of 2.7 to 5.4 mm from Fletcher 2016, Eur
 * Spine J 25:2999. The individual values are assumed; the vessels of the shipped patient run beside them.
 * Wedges: L5 after a CT series (30.3 mm in front, 26.3 behind), the others assumed. Ratio of the end plates,
 * pedicles of the lumbar spine and spans: near Panjabi, plus 5 % for a man; the pedicle of L5 lies between
 * Panjabi's 18 mm and the 12.9 mm of the CT series. Pedicles of T1, T4 and T12, width and angle: near
 * PMC4857161 (CT: 4.5 mm at T4, 8.3 mm at -10 degrees at T12). Lumbar angles: Zindrick 1987, Spine 12:160.
 * Canal of L5: CT; others: Panjabi. Slopes and lengths of spinous processes, and the places of the facets,
 * are assumed; the facets' angles are common figures: cervical 45 degrees, thoracic nearly frontal, lumbar 25
 * to 50 degrees from the midplane. */
const std::array<SpineLevel, SPINE_LEVELS> TABLE = {{
    // name h wedge  w    d  ratio  disc  pedicle      angle canal    span  spinous  facet
    {"C1", 13.0, 0.0, 22, 11.0, 1.00, 3.0, 7.0, 7.0, 30, 28, 30, 80, 20, 6, 20, -2, 90, 80},
    {"C2", 20.0, 0.0, 19, 15.5, 1.05, 5.0, 7.0, 8.0, 40, 25, 18, 54, 20, 15, 19, -4, 90, 75},
    {"C3", 12.0, 0.0, 19, 15.5, 1.08, 5.0, 5.6, 7.4, 43, 24, 15, 53, 22, 14, 21, 6, 90, 45},
    {"C4", 12.2, 0.0, 20, 15.8, 1.09, 5.0, 5.6, 7.4, 45, 24, 15, 52, 22, 14, 21, 6, 90, 45},
    {"C5", 12.5, 0.0, 21, 16.0, 1.10, 5.0, 5.8, 7.4, 44, 24, 15, 52, 22, 15, 21, 6, 90, 45},
    {"C6", 13.0, 0.0, 22, 16.5, 1.09, 5.0, 6.0, 7.4, 41, 24, 15, 56, 24, 20, 21, 7, 90, 42},
    {"C7", 14.0, -0.5, 25, 17.0, 1.07, 5.0, 6.9, 7.6, 36, 23, 15, 70, 26, 30, 20, 9, 88, 38},
    {"T1", 16.5, -0.8, 28, 17.0, 1.06, 3.8, 9.3, 9.6, 35, 21, 16, 78, 24, 33, 17, 10, 84, 28},
    {"T2", 17.5, -0.8, 27.5, 18.0, 1.05, 3.2, 7.4, 11.0, 27, 19, 16, 71, 30, 33, 13, 10, 82, 22},
    {"T3", 18.0, -1.0, 27, 19.5, 1.05, 3.0, 5.6, 11.6, 20, 18, 16, 65, 37, 34, 12, 10, 82, 20},
    {"T4", 18.5, -1.2, 27, 21.0, 1.05, 2.9, 4.8, 12.0, 16, 17.5, 16, 61, 44, 36, 11.5, 10, 82, 18},
    {"T5", 19.0, -1.3, 27.5, 23.0, 1.04, 3.2, 5.0, 12.0, 14, 17.5, 16, 61, 51, 38, 11.5, 10, 82, 18},
    {"T6", 19.5, -1.3, 28, 24.5, 1.04, 3.6, 5.4, 12.2, 12, 17.5, 16, 62, 55, 39, 11.5, 10, 82, 18},
    {"T7", 20.0, -1.3, 29, 26.0, 1.03, 4.0, 5.9, 12.3, 11, 17.5, 16, 63, 56, 39, 11.5, 10, 82, 18},
    {"T8", 20.5, -1.3, 30, 27.5, 1.03, 4.3, 6.7, 12.5, 9, 18, 16, 63, 53, 37, 11.5, 10, 82, 18},
    {"T9", 21.0, -1.2, 31.5, 28.5, 1.05, 4.8, 7.7, 13.7, 7, 18, 16, 62, 45, 34, 11.5, 10, 82, 16},
    {"T10", 22.0, -1.2, 33, 29.0, 1.06, 5.3, 8.8, 14.7, 5, 18.5, 16, 59, 34, 32, 11.5, 11, 82, 14},
    {"T11", 23.0, -1.2, 36, 29.5, 1.06, 6.0, 9.0, 16.0, -2, 20, 16, 53, 22, 29, 12, 11, 78, 10},
    {"T12", 24.5, -1.2, 40, 30.0, 1.05, 7.5, 8.5, 16.7, -8, 22, 17, 49, 12, 28, 12, 12, 70, 6},
    {"L1", 26.0, -1.2, 43, 31.0, 1.05, 9.0, 8.9, 15.4, 11, 23.5, 18, 75, 8, 30, 12.5, 14, 25, 2},
    {"L2", 27.0, -0.6, 45, 32.0, 1.06, 10.5, 9.3, 15.2, 12, 24, 18, 80, 6, 32, 13.5, 15, 28, 2},
    {"L3", 27.5, 0.2, 47, 33.0, 1.07, 11.5, 10.8, 15.0, 14, 24.5, 18, 90, 5, 33, 15, 15, 35, 2},
    {"L4", 27.5, 1.2, 49, 34.0, 1.06, 12.5, 13.2, 14.6, 18, 26, 18, 83, 6, 30, 17, 15, 42, 2},
    {"L5", 27.0, 3.6, 51, 34.0, 1.03, 11.0, 15.5, 14.2, 26, 28, 16, 94, 10, 25, 20, 15, 50, 4},
}};

/* How much lower the front of a vertebral body is because of an added kyphosis. Goh 2000 (Rheumatology
 * 39:310): kyphosis follows the shape of the bodies more than that of the discs; the share is assumed. */
double bend_wedge_mm(const SpineBend &bend, const Vertebra &v)
{
    constexpr double BODIES = 0.6, REACH_MM = 1.0;
    const auto slope = [&](double y_mm) {
        return (spine_shift_mm(bend, y_mm + REACH_MM).z() - spine_shift_mm(bend, y_mm - REACH_MM).z()) /
               (2.0 * REACH_MM);
    };
    const double half_mm = 0.5 * (v.height_mm + v.disc_below_mm), y_mm = v.centre_mm.y();
    return BODIES * v.depth_mm * (slope(y_mm + half_mm) - slope(y_mm - half_mm));
}

/* The direction to the patient's left in a vertebra. */
Vec3 left_of(const Vertebra &v)
{
    return (Vec3::UnitX() - v.up.x() * v.up).normalized();
}

} // namespace

const std::array<SpineLevel, SPINE_LEVELS> &levels()
{
    return TABLE;
}

/* Defines the curve through the centres of the vertebrae in the sagittal plane. The curve of the spine has a
 * kyphosis whose rearmost point is T7, and two lordoses whose foremost points are L3 and C5. */
double spine_course_z_mm(double y_mm)
{
    static const Spline course({-205, -188, -165, -130, -90, -45, 0, 45, 100, 150, 200, 250, 300, 360, 410},
                               {-52, -45, -37, -30, -29, -35, -45, -55, -65, -68.5, -65, -54, -41, -36, -44});
    return course.at(y_mm);
}

std::vector<Vertebra> vertebrae(const SkeletonShape &shape)
{
    // Panjabi's tables: a woman's end plates are 0.87 times as wide as a man's, and she is 0.93 times as
    // tall.
    const double girth = shape.sex == Sex::woman ? 0.95 : 1.0;
    std::vector<Vertebra> all;
    for (const SpineLevel &level : levels()) {
        Vertebra &v = all.emplace_back();
        v.name = level.name;
        v.height_mm = level.height_mm;
        v.wedge_mm = level.wedge_mm;
        v.width_mm = girth * level.width_mm;
        v.depth_mm = girth * level.depth_mm;
        v.disc_below_mm = level.disc_below_mm;
        v.left = side_difference(shape.sides_seed, all.size() - 1);
    }
    auto place = [&](Vertebra &v, double y_mm) {
        const Vec3 above = spine_shift_mm(shape.bend, y_mm + 8.0),
                   below = spine_shift_mm(shape.bend, y_mm - 8.0);
        const double slope = (spine_course_z_mm(y_mm + 8.0) - spine_course_z_mm(y_mm - 8.0)) / 16.0;
        v.centre_mm = Vec3(0, y_mm, spine_course_z_mm(y_mm)) + spine_shift_mm(shape.bend, y_mm);
        v.up = (Vec3(0, 1, slope) + (above - below) / 16.0).normalized();
        v.front = left_of(v).cross(v.up);
        v.wedge_mm -= bend_wedge_mm(shape.bend, v);
        return v.up.y();
    };
    // The vertebrae are stacked along the curve of the spine, up and down from the disc between T12 and L1 at
    // y = 0.
    double y = 0.5 * all[T12].disc_below_mm;
    for (size_t i = L1; i-- > 0;) {
        const double rise = place(all[i], y + 0.5 * all[i].height_mm);
        y += all[i].height_mm * rise + (i > 0 ? all[i - 1].disc_below_mm * rise : 0.0);
    }
    y = -0.5 * all[T12].disc_below_mm;
    for (size_t i = L1; i < all.size(); i++) {
        const double rise = place(all[i], y - 0.5 * all[i].height_mm);
        y -= (all[i].height_mm + all[i].disc_below_mm) * rise;
    }
    return all;
}

Frame frame_of(const Vertebra &vertebra)
{
    Frame frame{vertebra.centre_mm, {}};
    frame.rotation << left_of(vertebra), vertebra.up, vertebra.front;
    return frame;
}

FacetJoint facet_joint(const std::vector<Vertebra> &spine, size_t index, double s)
{
    // The joint of L5 and the sacrum lies below L5 and a little wider than that of L4 and L5.
    const bool sacral = index == SPINE_LEVELS;
    const Vertebra &v = spine[sacral ? L5 : index];
    const SpineLevel &level = levels()[sacral ? L5 : index];
    const Frame f = frame_of(v);
    const double disc_mm = index == 0 ? 0.0 : (sacral ? v : spine[index - 1]).disc_below_mm;
    const double x = level.facet_x_mm + (sacral ? 2.5 : 0.0);
    const double y = sacral ? -0.5 * v.height_mm - 0.75 * disc_mm : 0.5 * v.height_mm + 0.15 * disc_mm;
    const double angle =
                     (level.facet_angle_deg + (sacral ? 5.0 : 0.0) + s * v.left.facet_turned_deg) * DEGREE,
                 tilt = level.facet_tilt_deg * DEGREE;
    FacetJoint joint;
    joint.centre = f.at(s * x, y, -0.5 * v.depth_mm - level.facet_behind_mm - (sacral ? 4.0 : 0.0));
    const Vec3 normal =
        f.along(-s * std::cos(angle) * std::cos(tilt), std::sin(tilt), -std::sin(angle) * std::cos(tilt));
    const Vec3 across = f.along(0, 1, 0).cross(normal).normalized();
    joint.rotation << across, normal.cross(across), normal;
    return joint;
}

} // namespace anatomy
