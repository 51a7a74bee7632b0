/* The shapes of the vertebrae of the neck. Where levels.cpp gives no measure, it is assumed. */
#include "tools/anatomy/skeleton/levels.hpp"
#include "tools/anatomy/skeleton/vertebral_body.hpp"
#include <cmath>

namespace anatomy
{

namespace
{

/* Adds the articular pillar between the joints above and below, which has the shape of a lozenge. */
void add_pillar(Part &part, const std::vector<Vertebra> &spine, size_t index, double s)
{
    constexpr double JOINT_GAP_MM = 1.4, THICK_MM = 2.2;
    const FacetJoint upper = facet_joint(spine, index, s), lower = facet_joint(spine, index + 1, s);
    const Vec3 top = upper.centre - (THICK_MM + 0.5 * JOINT_GAP_MM) * upper.rotation.col(2);
    const Vec3 low = lower.centre + (THICK_MM + 0.5 * JOINT_GAP_MM) * lower.rotation.col(2);
    part.add<Ellipsoid>(top, Vec3(6.0, 5.5, THICK_MM), upper.rotation).cortex_mm = 0.8;
    part.add<Ellipsoid>(low, Vec3(6.0, 5.5, THICK_MM), lower.rotation).cortex_mm = 0.8;
    part.rod({top, low}, {4.8, 4.8}, 0.9);
}

void add_half_arch(Part &part, const std::vector<Vertebra> &spine, size_t index, double s)
{
    const Vertebra &v = spine[index];
    const SpineLevel &level = levels()[index];
    const Frame f = frame_of(v);
    const double back = -0.5 * v.depth_mm, arch = back - level.canal_depth_mm - 2.0, h = v.height_mm;
    const double pillar_x = level.facet_x_mm, pillar_z = back - level.facet_behind_mm;
    const Vec3 pillar = f.at(s * pillar_x, 0, pillar_z);
    add_pillar(part, spine, index, s);
    part.rod({f.at(s * 0.38 * v.width_mm, 0.1 * h, back + 3.0), pillar},
             {0.5 * level.pedicle_height_mm, 0.5 * level.pedicle_height_mm - 0.4}, 0.8);
    // Two plates make the lamina, which overlaps the next one like a tile.
    const Vec3 top = f.at(0, 0.2 * h, arch + 1.0), low = f.at(0, -0.55 * h, arch - 2.0);
    const Vec3 outer_top = f.at(s * (pillar_x - 2.0), 0.35 * h, pillar_z - 5.0);
    const Vec3 outer_low = f.at(s * (pillar_x - 2.0), -0.5 * h, pillar_z - 6.0);
    part.plate(top, outer_top, outer_low, 1.9, 0.8);
    part.plate(top, low, outer_low, 1.9, 0.8);
    // The transverse process has two bars, before and behind the vertebral artery, which meet at its tip.
    const Vec3 tip = f.at(s * (0.5 * level.transverse_span_mm - 2.5), -0.15 * h, back + 1.0);
    part.rod({f.at(s * 0.42 * v.width_mm, 0, back + 8.0), tip}, {2.6, 2.4}, 0.7);
    part.rod({pillar, tip}, {3.0, 2.6}, 0.7);
}

void add_spinous(Part &part, const Vertebra &v, const SpineLevel &level, bool forked)
{
    const Frame f = frame_of(v);
    const double slope = level.spinous_slope_deg * DEGREE;
    const Vec3 root = f.at(0, -0.15 * v.height_mm, -0.5 * v.depth_mm - level.canal_depth_mm - 2.0);
    const Vec3 tip = root + level.spinous_mm * f.along(0, -std::sin(slope), -std::cos(slope));
    part.rod({root, 0.5 * (root + tip), tip}, {4.6, 3.4, 3.2}, 0.9);
    if (!forked) return;
    for (double s : {-1.0, 1.0})
        part.rod({0.35 * root + 0.65 * tip, tip + f.along(s * 4.0, -1.5, 0)}, {2.6, 2.2}, 0.8);
}

Part common_part(const std::vector<Vertebra> &spine, size_t index)
{
    const Vertebra &v = spine[index];
    const SpineLevel &level = levels()[index];
    const Frame f = frame_of(v);
    const double upper = 2.0 * v.width_mm / (1.0 + level.lower_ratio);
    Part part(2.0);
    part.add<VertebralBody>(v.centre_mm, f.rotation,
                            BodyMeasures{upper, upper * level.lower_ratio, v.depth_mm, v.height_mm,
                                         v.height_mm, 1.0, 0.5, 0.0, 0.0})
        .cortex_mm = 0.8;
    for (double s : {-1.0, 1.0}) {
        add_half_arch(part, spine, index, s);
        // The upper edge rises at both sides (uncinate process).
        if (index > C2)
            part.add<Ellipsoid>(f.at(s * 0.42 * v.width_mm, 0.5 * v.height_mm, -2.0), Vec3(2.6, 4.0, 5.0),
                                f.rotation)
                .cortex_mm = 0.8;
    }
    add_spinous(part, v, level, index < C7 - 1);
    return part;
}

/* The axis, C2, has the dens, which stands behind the front arch of the atlas. */
Part axis_part(const std::vector<Vertebra> &spine)
{
    constexpr double DENS_MM = 16.0;
    Part part = common_part(spine, C2);
    const Vertebra &v = spine[C2];
    const Frame f = frame_of(v);
    const double top = 0.5 * v.height_mm;
    part.rod({f.at(0, top - 4.0, 0), f.at(0, top + 0.5 * DENS_MM, 0.5), f.at(0, top + DENS_MM - 4.0, -1)},
             {6.0, 4.6, 4.8}, 1.0);
    return part;
}

/* The atlas, C1, is a ring: two thick lateral masses, a short front arch and a long rear arch. */
Part atlas_part(const std::vector<Vertebra> &spine)
{
    Part part(2.0);
    const Vertebra &v = spine[0];
    const SpineLevel &level = levels()[0];
    const Frame f = frame_of(v);
    const double ahead = 11.0, behind = -0.5 * v.depth_mm - level.canal_depth_mm + 6.0;
    for (double s : {-1.0, 1.0}) {
        const Vec3 mass = f.at(s * 19.0, 0, -3.0);
        part.add<Ellipsoid>(mass, Vec3(7.0, 7.5, 10.0), f.rotation).cortex_mm = 1.0;
        part.rod({mass, f.at(s * (0.5 * level.transverse_span_mm - 3.0), -1.0, -5.0)}, {4.0, 3.4}, 0.8);
        part.rod({mass, f.at(s * 11.0, 0, 8.0), f.at(0, 0, ahead)}, {4.0, 4.0, 4.8}, 1.0);
        part.rod({mass, f.at(s * 18.0, 0, -15.0), f.at(s * 10.0, 0, behind + 3.0), f.at(0, 0, behind)},
                 {4.0, 3.4, 3.6, 4.2}, 1.0);
    }
    return part;
}

} // namespace

Part cervical_part(const std::vector<Vertebra> &spine, size_t index)
{
    if (index == 0) return atlas_part(spine);
    return index == C2 ? axis_part(spine) : common_part(spine, index);
}

} // namespace anatomy
