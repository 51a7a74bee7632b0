/* The spine. The heights of vertebrae and discs are rounded from published measurements. The lumbar heights
 * are near those of Gilad and Nissan 1985, J Anat 143:115. The thoracic discs of 2.7 to 5.4 mm come from
 * Fletcher 2016, Eur Spine J 25:2999. The height of each individual vertebra and disc is assumed. */
#include "tools/anatomy/skeleton.hpp"
#include <cmath>

namespace anatomy
{

namespace
{

struct Size {
    const char *name;
    double height_mm, width_mm, depth_mm, disc_below_mm;
};

const Size SIZES[] = {
    {"C5", 12.5, 21, 16, 5.0},  {"C6", 13, 22, 16.5, 5.0},   {"C7", 14, 25, 17, 5.0},
    {"T1", 16.5, 28, 17, 3.8},  {"T2", 17.5, 27.5, 18, 3.2}, {"T3", 18, 27, 19.5, 3.0},
    {"T4", 18.5, 27, 21, 2.9},  {"T5", 19, 27.5, 23, 3.2},   {"T6", 19.5, 28, 24.5, 3.6},
    {"T7", 20, 29, 26, 4.0},    {"T8", 20.5, 30, 27.5, 4.3}, {"T9", 21, 31.5, 28.5, 4.8},
    {"T10", 22, 33, 29, 5.3},   {"T11", 23, 36, 29.5, 6.0},  {"T12", 24.5, 40, 30, 7.5},
    {"L1", 26, 43, 31, 9.0},    {"L2", 27, 45, 32, 10.5},    {"L3", 27.5, 47, 33, 11.5},
    {"L4", 27.5, 49, 34, 12.5}, {"L5", 27, 51, 34, 11.0},
};

/* Defines the curve through the centres of the vertebrae in the sagittal plane. The curve of the spine has a
 * kyphosis whose rearmost point is T7, and a lordosis whose foremost point is L3. */
double course_z_mm(double y_mm)
{
    static const Spline course({-205, -188, -165, -130, -90, -45, 0, 45, 100, 150, 200, 250, 300, 360},
                               {-52, -45, -37, -30, -29, -35, -45, -55, -65, -68.5, -65, -54, -41, -38});
    return course.at(y_mm);
}

struct Frame {
    Vec3 centre;
    Eigen::Matrix3d rotation; // columns: left, up, front
    Vec3 at(double x, double y, double z) const { return centre + rotation * Vec3(x, y, z); }
};

Frame frame_of(const Vertebra &v)
{
    Frame frame{v.centre_mm, {}};
    frame.rotation.col(0) = Vec3::UnitX();
    frame.rotation.col(1) = v.up;
    frame.rotation.col(2) = v.front;
    return frame;
}

/* Returns 0 for vertebrae down to T10 (thoracic shape), and 1 for L2 and below (lumbar shape). For the
 * vertebrae between T10 and L2 the function returns values between 0 and 1. */
double lumbar_share(size_t index)
{
    return std::min(1.0, std::max(0.0, (static_cast<double>(index) - 12.0) / 4.0));
}

void add_arch(Part &part, const Frame &f, const Vertebra &v, double lumbar)
{
    const double back = -0.5 * v.depth_mm, arch = back - 15.0 - 3.0 * lumbar;
    const double pedicle_x = 0.30 * v.width_mm + 1.5, pedicle_y = 0.18 * v.height_mm;
    const double radius = 3.6 + 2.2 * lumbar;
    for (double s : {-1.0, 1.0}) {
        part.rod({f.at(s * pedicle_x, pedicle_y, back + 4), f.at(s * pedicle_x, pedicle_y, arch + 5)},
                 {radius, radius}, 1.0);
        // Two plates, the laminae, close the spinal canal at the back.
        const Vec3 top = f.at(0, 0.15 * v.height_mm, arch - 6), low = f.at(0, -0.45 * v.height_mm, arch - 9);
        const Vec3 outer_top = f.at(s * pedicle_x, 0.25 * v.height_mm, arch + 3);
        const Vec3 outer_low = f.at(s * pedicle_x, -0.5 * v.height_mm, arch + 1);
        part.plate(top, outer_top, outer_low, 2.4, 0.8);
        part.plate(top, low, outer_low, 2.4, 0.8);
        // The code below adds the articular processes.
        const double facet_x = pedicle_x + 1.0 + 2.0 * lumbar;
        const double reach = 0.5 * (v.height_mm + v.disc_below_mm);
        part.rod({f.at(s * facet_x, 0, arch + 3), f.at(s * (facet_x + 1.5), reach - 1.5, arch + 3)},
                 {3.0 + 2.0 * lumbar, 2.6 + 2.2 * lumbar});
        part.rod({f.at(s * (facet_x - 1), 0, arch), f.at(s * (facet_x - 3.5 * lumbar), -reach - 1, arch - 1)},
                 {3.0 + 2.0 * lumbar, 2.6 + 1.6 * lumbar});
    }
}

void add_processes(Part &part, const Frame &f, const Vertebra &v, size_t index, double lumbar)
{
    const double back = -0.5 * v.depth_mm, arch = back - 15.0 - 3.0 * lumbar;
    const double pedicle_x = 0.30 * v.width_mm + 1.5;
    const bool cervical = index < 3;
    // The transverse processes are long and horizontal on L3, and short and swept back on the thoracic
    // vertebrae.
    const double span = cervical ? 24.0
                                 : (lumbar > 0.5 ? 44.0 - 2.5 * std::abs(static_cast<double>(index) - 17.0)
                                                 : 33.0 - 0.7 * (static_cast<double>(index) - 3.0));
    for (double s : {-1.0, 1.0}) {
        const Vec3 root = f.at(s * pedicle_x, 0.10 * v.height_mm, arch + 5);
        const Vec3 tip =
            f.at(s * span, 0.15 * v.height_mm + 2.0 * (1 - lumbar), arch + 3 - 9.0 * (1 - lumbar));
        Tube &tube = part.add<Tube>(sample_curve({root, 0.5 * (root + tip) + f.rotation.col(1) * 1.5, tip},
                                                 {6.0, 5.2, 3.2 + 0.8 * (1 - lumbar)}, 4.0),
                                    f.rotation.col(1), 0.62);
        tube.cortex_mm = 0.9;
    }
    // The spinous process is a slender spike that slopes down on a thoracic vertebra, and a blade on a lumbar
    // vertebra.
    const double drop = (cervical ? 0.35 : 1.35 - 1.0 * lumbar) * v.height_mm;
    const double length = cervical ? 24.0 : 25.0 + 3.0 * lumbar;
    const Vec3 root_top = f.at(0, 0.1 * v.height_mm, arch - 5),
               root_low = f.at(0, -0.4 * v.height_mm, arch - 8);
    const Vec3 tip_top = f.at(0, -drop + 5.0 * lumbar, arch - length);
    const Vec3 tip_low = f.at(0, -drop - 4.0 - 8.0 * lumbar, arch - length + 1);
    part.plate(root_top, root_low, tip_low, 3.0, 0.7);
    part.plate(root_top, tip_top, tip_low, 3.0, 0.7);
    part.rod({tip_top, tip_low}, {3.6, 3.6 + 0.4 * lumbar}, 0.7);
}

Part vertebra_part(const Vertebra &v, size_t index)
{
    const double lumbar = lumbar_share(index);
    const Frame f = frame_of(v);
    Part part(3.0);
    Drum &drum = part.add<Drum>(v.centre_mm, f.rotation, v.width_mm, v.height_mm, v.depth_mm);
    drum.cortex_mm = 0.8;
    add_arch(part, f, v, lumbar);
    add_processes(part, f, v, index, lumbar);
    return part;
}

/* Adds sacrum and coccyx as a curved, tapering slab with four pairs of holes. */
Part sacrum_part()
{
    Part part(5.0);
    const std::vector<Vec3> course = {
        {0, -205, -54}, {0, -228, -71}, {0, -250, -83}, {0, -270, -88}, {0, -286, -84}};
    Tube &slab = part.add<Tube>(sample_curve(course, {30, 30, 27, 23, 15}, 4.0), Vec3::UnitX(), 0.42);
    slab.cortex_mm = 1.3;
    part.rod({{0, -292, -82}, {0, -310, -70}, {0, -320, -58}}, {7, 5, 3});
    Eigen::Matrix3d tilt;
    const Vec3 up = Vec3(0, 0.80, 0.60);
    tilt << Vec3::UnitX(), up, Vec3::UnitX().cross(up);
    part.add<Drum>(Vec3(0, -207, -55), tilt, 52.0, 28.0, 33.0).cortex_mm = 1.2;
    for (double s : {-1.0, 1.0}) {
        // The wings (alae) of the sacrum reach the sacroiliac joints.
        part.add<Ellipsoid>(side(s, 33, -216, -63), Vec3(20, 17, 12)).cortex_mm = 1.2;
        part.add<Ellipsoid>(side(s, 33, -236, -73), Vec3(15, 17, 10)).cortex_mm = 1.2;
        part.rod({side(s, 18, -197, -74), side(s, 17, -188, -74)}, {5, 4.5});
        for (int hole = 0; hole < 4; hole++) {
            const double y = -221.0 - 19.0 * hole, x = 19.0 - 2.0 * hole,
                         z = -66.0 - 7.0 * hole + 1.3 * hole * hole;
            const double radius = 5.0 - 0.5 * hole;
            part.cut<Tube>(sample_curve({side(s, x, y - 12, z + 24), side(s, x, y + 12, z - 24)},
                                        {radius, radius}, 8.0));
        }
    }
    part.rod({{0, -212, -82}, {0, -238, -96}, {0, -262, -101}}, {4.5, 4, 3});
    return part;
}

} // namespace

std::vector<Vertebra> vertebrae(const SkeletonShape &shape)
{
    // Panjabi's tables: a woman's end plates are 0.87 times as wide as a man's, and she is 0.93 times as
    // tall.
    const double girth = shape.sex == Sex::woman ? 0.95 : 1.0;
    // The vertebrae are stacked along the curve of the spine, up and down from the disc between T12 and L1 at
    // y = 0.
    constexpr size_t FIRST_LUMBAR = 15;
    std::vector<Vertebra> all;
    for (const Size &size : SIZES)
        all.push_back({size.name,
                       size.height_mm,
                       girth * size.width_mm,
                       girth * size.depth_mm,
                       size.disc_below_mm,
                       {},
                       {},
                       {}});
    auto place = [&](Vertebra &v, double y_mm) {
        const double slope = (course_z_mm(y_mm + 8.0) - course_z_mm(y_mm - 8.0)) / 16.0;
        v.centre_mm = Vec3(0, y_mm, course_z_mm(y_mm));
        v.up = Vec3(0, 1, slope).normalized();
        v.front = Vec3::UnitX().cross(v.up);
        return v.up.y();
    };
    double y = 0.5 * all[FIRST_LUMBAR - 1].disc_below_mm;
    for (size_t i = FIRST_LUMBAR; i-- > 0;) {
        const double rise = place(all[i], y + 0.5 * all[i].height_mm);
        y += all[i].height_mm * rise + (i > 0 ? all[i - 1].disc_below_mm * rise : 0.0);
    }
    y = -0.5 * all[FIRST_LUMBAR - 1].disc_below_mm;
    for (size_t i = FIRST_LUMBAR; i < all.size(); i++) {
        const double rise = place(all[i], y - 0.5 * all[i].height_mm);
        y -= (all[i].height_mm + all[i].disc_below_mm) * rise;
    }
    return all;
}

Solid spine_bones(const SkeletonShape &shape)
{
    Solid solid;
    const auto all = vertebrae(shape);
    for (size_t i = 0; i < all.size(); i++) solid.add(vertebra_part(all[i], i));
    solid.add(sacrum_part());
    solid.enlarge(shape.scale);
    return solid;
}

} // namespace anatomy
