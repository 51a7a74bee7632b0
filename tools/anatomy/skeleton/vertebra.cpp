/* The shapes of the thoracic and lumbar vertebrae. */
#include "tools/anatomy/skeleton/levels.hpp"
#include "tools/anatomy/skeleton/vertebral_body.hpp"
#include <cmath>

namespace anatomy
{

namespace
{

/* Gathers what the pieces of one vertebra need. */
struct Builder {
    Part &part;
    const std::vector<Vertebra> &spine;
    size_t index;
    const Vertebra &v;
    const SpineLevel &level;
    Frame f;
    double lumbar; // 0 down to T10, 1 from L1 on

    double back() const { return -0.5 * v.depth_mm; }
    double pedicle_x() const { return 0.5 * (level.canal_width_mm + level.pedicle_width_mm); }
    double pedicle_y() const { return 0.5 * v.height_mm - 0.5 * level.pedicle_height_mm - 0.5; }
    double lamina_half_mm() const { return 2.9 + 0.4 * lumbar; } // Egwu 2019: 7 mm thick; assumed less
    /* Returns the middle of the lamina, behind the canal. */
    double arch() const { return back() - level.canal_depth_mm - lamina_half_mm(); }
    Vec3 pedicle_end(double s) const
    {
        return f.at(s * (pedicle_x() + 1.5), pedicle_y(), back() - 8.0 - 2.5 * lumbar);
    }
};

void add_body(const Builder &b, const SkeletonShape &shape)
{
    // Osteophytes are most frequent at T7 to T11 on the right, where no aorta beats, and at L3 and L4 on both
    // sides. Their lengths, 2 to 8 mm, are common figures.
    constexpr double SPUR_MM = 7.0;
    constexpr size_t T7 = T1 + 6, L2 = L1 + 1;
    const bool thoracic = b.index >= T7 && b.index <= T12, lumbar = b.index >= L2;
    // Levels and sides differ (assumed).
    const double level = static_cast<double>(b.index);
    const double right_share = 0.65 + 0.35 * std::sin(2.6 * level),
                 left_share = 0.65 + 0.35 * std::sin(1.7 * level);
    const double right = shape.osteophytes * SPUR_MM * right_share * (thoracic || lumbar ? 1.0 : 0.2);
    const double left = shape.osteophytes * SPUR_MM * left_share * (lumbar ? 1.0 : 0.0);
    const double upper = 2.0 * b.v.width_mm / (1.0 + b.level.lower_ratio);
    BodyMeasures measures{upper,
                          upper * b.level.lower_ratio,
                          b.v.depth_mm,
                          b.v.height_mm + 0.5 * b.v.wedge_mm,
                          b.v.height_mm - 0.5 * b.v.wedge_mm,
                          1.3 + 0.9 * b.lumbar,
                          1.5,
                          right,
                          left};
    b.part.add<VertebralBody>(b.v.centre_mm, b.f.rotation, measures).cortex_mm = 0.8;
}

/* Adds a tube with an oval section, whose half-height is `radii_mm`. */
Tube &oval(const Builder &b, const std::vector<Vec3> &points, const std::vector<double> &radii_mm,
           const Vec3 &flat, double thinness, double cortex_mm)
{
    Tube &tube = b.part.add<Tube>(sample_curve(points, radii_mm, 4.0), flat, thinness);
    tube.cortex_mm = cortex_mm;
    return tube;
}

/* A pedicle is narrowest in its middle and flares into the body and into the arch. */
void add_pedicle(const Builder &b, double s)
{
    const double angle = b.level.pedicle_angle_deg * DEGREE, half = 0.5 * b.level.pedicle_height_mm;
    const Vec3 neck = b.f.at(s * b.pedicle_x(), b.pedicle_y(), b.back() - 3.0 - b.lumbar);
    const Vec3 ahead = b.f.along(-s * std::sin(angle), 0.0, std::cos(angle));
    oval(b, {neck + 9.0 * ahead, neck + 4.0 * ahead, neck, b.pedicle_end(s)},
         {1.15 * half, 1.1 * half, half, 0.95 * half}, b.f.along(0, 1, 0),
         (1.0 + s * b.v.left.pedicle_wider) * b.level.pedicle_width_mm / b.level.pedicle_height_mm, 0.9);
}

/* Adds the articular processes and the pieces of the arch that carry them. */
void add_facets(const Builder &b, double s)
{
    constexpr double JOINT_GAP_MM = 1.6; // the cartilage of both
    const double thick = 2.6 + 1.4 * b.lumbar, high = 6.0 + 2.2 * b.lumbar, wide = 5.2 + 2.0 * b.lumbar;
    const Vec3 root = b.pedicle_end(s);
    const FacetJoint upper = facet_joint(b.spine, b.index, s), lower = facet_joint(b.spine, b.index + 1, s);
    const Vec3 top = upper.centre - (thick + 0.5 * JOINT_GAP_MM) * upper.rotation.col(2);
    const Vec3 low = lower.centre + (thick + 0.5 * JOINT_GAP_MM) * lower.rotation.col(2);
    b.part.add<Ellipsoid>(top, Vec3(wide, high, thick), upper.rotation).cortex_mm = 1.0;
    b.part.add<Ellipsoid>(low, Vec3(wide, high, thick), lower.rotation).cortex_mm = 1.0;
    b.part.rod({root, 0.5 * (root + top), top}, {4.2 + 1.2 * b.lumbar, 3.6 + 1.0 * b.lumbar, thick}, 1.0);
    // The isthmus (pars interarticularis) joins the pedicle to the lower process.
    const Vec3 isthmus =
        b.f.at(s * (b.pedicle_x() - 1.5), -0.12 * b.v.height_mm, b.back() - b.level.canal_depth_mm + 2.0);
    oval(b, {root, isthmus, low}, {4.5 + b.lumbar, 5.0 + 1.0 * b.lumbar, 4.0 + b.lumbar}, b.f.along(1, 0, 0),
         0.72, 1.3);
}

void add_lamina(const Builder &b, double s)
{
    const double h = b.v.height_mm, thick = b.lamina_half_mm(), x = b.pedicle_x() - 1.0;
    const double slant = 4.0 - 1.0 * b.lumbar; // the lower edge lies further behind
    const double top_y = (0.22 - 0.12 * b.lumbar) * h, low_y = -(0.52 + 0.02 * b.lumbar) * h;
    const Vec3 top = b.f.at(0, top_y, b.arch()), low = b.f.at(0, low_y, b.arch() - slant);
    const Vec3 outer_top = b.f.at(s * x, top_y + 2.0, b.arch() + 8.0);
    const Vec3 outer_low = b.f.at(s * (x - 1.5), low_y - 1.0, b.arch() + 6.0 - slant);
    b.part.plate(top, outer_top, outer_low, Vec3(thick, thick - 0.4, thick - 0.8), 1.2);
    b.part.plate(top, low, outer_low, Vec3(thick, thick, thick - 0.8), 1.2);
}

/* The transverse process of a thoracic vertebra is stout and swept back and up, and carries a club with the
 * facet for the rib. That of a lumbar vertebra is long, flat and nearly horizontal; that of L5 is a stout
 * cone. */
void add_transverse(const Builder &b, double s)
{
    const double tip_x = 0.5 * b.level.transverse_span_mm + s * b.v.left.transverse_longer_mm;
    const double higher = s * b.v.left.transverse_higher_mm;
    const Vec3 root = b.pedicle_end(s), up = b.f.along(0, 1, 0);
    if (b.index < L1) {
        const double swept = 0.62 * (tip_x - b.pedicle_x());
        const Vec3 club = b.f.at(s * (tip_x - 4.0), b.pedicle_y() + 1.0 + higher, b.back() - 9.0 - swept);
        oval(b, {root, 0.5 * (root + club), club}, {5.5, 4.6, 4.8}, up, 0.85, 1.0);
        if (b.index < T12) b.part.add<Ellipsoid>(club, Vec3(4.6, 6.0, 4.6), b.f.rotation).cortex_mm = 1.0;
        return;
    }
    const bool last = b.index == L5;
    const double rise = (b.index >= L5 - 1 ? 4.0 : b.index == L1 ? 2.0 : 0.0) + higher;
    const Vec3 start = b.f.at(s * (b.pedicle_x() + 1.0), b.pedicle_y() - 1.0, b.back() - 7.0);
    const Vec3 tip = b.f.at(s * (tip_x - (last ? 3.6 : 2.2)), b.pedicle_y() - 1.0 + rise, b.back() - 13.0);
    const Vec3 middle = 0.5 * (start + tip) - 0.5 * up;
    if (last)
        oval(b, {start, middle, tip}, {8.5, 7.0, 4.5}, up, 0.85, 0.9);
    else
        oval(b, {start, middle, tip}, {7.0, 5.2, 3.6}, up, 0.55, 0.9);
}

/* The spinous process is a slender spike with a three-cornered root on a thoracic vertebra, and a blade with
 * a thick lower and rear edge, like a hatchet, on a lumbar one. */
void add_spinous(const Builder &b)
{
    const double slope = b.level.spinous_slope_deg * DEGREE, h = b.v.height_mm;
    const double start_z = b.arch() - 1.0;
    const Vec3 along = b.f.along(0, -std::sin(slope), -std::cos(slope));
    const double length = b.level.spinous_mm - b.lamina_half_mm();
    const Vec3 aside = b.f.along(b.v.left.spinous_left_mm, 0, 0);
    if (b.index < T12) {
        const Vec3 root = b.f.at(0, -0.05 * h, start_z), low_root = b.f.at(0, -0.42 * h, start_z - 4.0);
        const Vec3 tip = root + length * along + aside;
        oval(b, {root, root + 0.5 * (length * along + aside), tip}, {6.5, 4.6, 3.4}, b.f.along(0, 1, 0), 0.68,
             1.0);
        b.part.plate(root, low_root, tip, Vec3(2.6, 3.2, 1.8), 1.0);
        b.part.add<Ellipsoid>(tip, Vec3(3.0, 4.2, 3.2), b.f.rotation).cortex_mm = 1.0;
        return;
    }
    const double high = 7.5 + 1.5 * b.lumbar; // half of the blade's height, 20 mm in all
    const Vec3 down = b.f.along(0, -1, 0);
    const Vec3 top = b.f.at(0, -0.02 * h, start_z), low = top + (2.0 * high - 2.0) * down;
    const Vec3 tip_top = top + (length - 3.0) * along + 1.5 * down + 0.7 * aside;
    const Vec3 tip_low = top + length * along + (2.0 * high - 1.0) * down + aside;
    // The blade widens backwards and downwards by 6 degrees, so that no ray of an AP view runs far along its
    // sides; these are thin, and the shadow is that of the tip (PMID 2781411).
    constexpr double CORTEX_MM = 0.5;
    b.part.plate(top, low, tip_low, Vec3(1.4, 1.6, 4.6), CORTEX_MM);
    b.part.plate(top, tip_top, tip_low, Vec3(1.4, 3.4, 4.6), CORTEX_MM);
    b.part.rod({tip_top, 0.5 * (tip_top + tip_low), tip_low}, {3.4, 4.2, 5.0}, CORTEX_MM);
    b.part.rod({low, 0.5 * (low + tip_low) + 0.8 * down, tip_low}, {1.8, 3.2, 5.0}, CORTEX_MM);
}

} // namespace

Part vertebra_part(const std::vector<Vertebra> &spine, size_t index, const SkeletonShape &shape)
{
    Part part(2.5);
    const double lumbar = index < T12 ? 0.0 : index == T12 ? 0.5 : 1.0;
    const Builder b{part, spine, index, spine[index], levels()[index], frame_of(spine[index]), lumbar};
    add_body(b, shape);
    for (double s : {-1.0, 1.0}) {
        add_pedicle(b, s);
        add_facets(b, s);
        add_lamina(b, s);
        add_transverse(b, s);
    }
    add_spinous(b);
    return part;
}

} // namespace anatomy
