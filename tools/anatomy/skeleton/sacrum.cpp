/* The shape of sacrum and coccyx. The sacrum is 110 mm broad and 108 mm long and its base slopes by 37
 * degrees (common figures for a man); all other measures are assumed. */
#include "tools/anatomy/skeleton/levels.hpp"
#include "tools/anatomy/skeleton/vertebral_body.hpp"
#include <cmath>

namespace anatomy
{

namespace
{

/* Holds one of the five fused vertebrae of the sacrum. The wing reaches from the body to wing_x_mm. */
struct Segment {
    double y, z, up_y, up_z;
    double width_mm, depth_mm, height_mm, wing_x_mm, wing_mm, hole_x_mm, hole_mm;
};

const Segment SEGMENTS[] = {
    {-209, -57.0, 0.80, 0.60, 52, 31, 27, 43, 13.0, 21.5, 6.4},
    {-230, -72.0, 0.84, 0.54, 42, 21, 24, 43, 11.0, 20.0, 5.8},
    {-249, -82.5, 0.93, 0.37, 34, 16, 21, 36, 9.0, 18.5, 4.6},
    {-267, -87.0, 1.00, 0.09, 29, 13, 19, 29, 7.5, 17.0, 4.0},
    {-283, -85.5, 0.99, -0.10, 25, 11, 16, 20, 5.5, 0.0, 0.0},
};

Frame frame_of(const Segment &segment)
{
    const Vec3 up = Vec3(0, segment.up_y, segment.up_z).normalized();
    Frame frame{Vec3(0, segment.y, segment.z), {}};
    frame.rotation << Vec3::UnitX(), up, Vec3::UnitX().cross(up);
    return frame;
}

/* Adds the wing of one side, whose outer face towards the hip bone slants backwards and inwards. */
void add_side(Part &part, double s, double wider)
{
    std::vector<Vec3> edge;
    std::vector<double> edge_radii;
    for (const Segment &segment : SEGMENTS) {
        const Frame f = frame_of(segment);
        const Vec3 root =
            f.at(s * 0.36 * segment.width_mm, 0.05 * segment.height_mm, -0.1 * segment.depth_mm);
        const Vec3 tip = f.at(s * wider * segment.wing_x_mm, 0.0, -0.22 * segment.depth_mm - 2.0);
        Tube &wing = part.add<Tube>(sample_curve({root, tip}, {0.92 * segment.wing_mm, segment.wing_mm}, 4.0),
                                    f.along(0, 1, 0), 0.78);
        wing.cortex_mm = 1.0;
        edge.push_back(tip);
        edge_radii.push_back(0.92 * segment.wing_mm);
    }
    part.rod(edge, edge_radii, 1.0);
    part.add<Ellipsoid>(side(s, wider * 46, -217, -76), Vec3(8, 19, 11)).cortex_mm = 1.0;
    for (size_t i = 0; i + 1 < std::size(SEGMENTS); i++) {
        const Segment &above = SEGMENTS[i];
        const Frame f = frame_of(above);
        const Vec3 hole = f.at(s * above.hole_x_mm, -0.52 * above.height_mm, 0.0);
        const Vec3 through = f.along(s * 0.25, 0.0, 1.0);
        part.cut<Tube>(sample_curve({hole - 30.0 * through, hole + 30.0 * through},
                                    {0.8 * above.hole_mm, 1.2 * above.hole_mm}, 6.0));
    }
}

/* Adds the roof of the canal with its crests, which the fused arches form. */
void add_roof(Part &part, const std::vector<Vertebra> &spine)
{
    const Frame first = frame_of(SEGMENTS[0]), third = frame_of(SEGMENTS[2]), fourth = frame_of(SEGMENTS[3]);
    const double deep = -0.5 * SEGMENTS[0].depth_mm - 16.0;
    part.rod({first.at(0, -4, deep - 4.0), frame_of(SEGMENTS[1]).at(0, 0, -27), third.at(0, 0, -19),
              fourth.at(0, -4, -13)},
             {3.6, 3.8, 3.4, 2.6}, 0.9);
    for (double s : {-1.0, 1.0}) {
        const Vec3 outer = first.at(s * 20, -2, -24), low = third.at(s * 11, -4, -14);
        part.plate(first.at(0, -6, deep), outer, low, 2.2, 0.9);
        part.plate(first.at(0, -6, deep), third.at(0, -4, -17), low, 2.2, 0.9);
        // The joint with L5 faces backwards and inwards.
        const FacetJoint joint = facet_joint(spine, SPINE_LEVELS, s);
        const Vec3 facet = joint.centre - 4.8 * joint.rotation.col(2);
        part.add<Ellipsoid>(facet, Vec3(7, 8, 4), joint.rotation).cortex_mm = 1.0;
        part.rod({facet, first.at(s * 23, 0, -15)}, {4.0, 7.0}, 1.0);
    }
}

} // namespace

Part sacrum_part(const std::vector<Vertebra> &spine, const SkeletonShape &shape)
{
    const double wider = shape.sex == Sex::woman ? WOMAN_PELVIS_WIDER : 1.0;
    Part part(4.0);
    for (const Segment &segment : SEGMENTS) {
        const Frame f = frame_of(segment);
        part.add<VertebralBody>(f.centre, f.rotation,
                                BodyMeasures{segment.width_mm, 0.86 * segment.width_mm, segment.depth_mm,
                                             segment.height_mm, segment.height_mm, 0.8, 0.0, 0.0, 0.0})
            .cortex_mm = 0.9;
    }
    // The bodies are fused, so their marrow is one.
    std::vector<Vec3> core;
    for (const Segment &segment : SEGMENTS) core.push_back(frame_of(segment).centre);
    part.rod(core, {12.0, 9.0, 6.8, 5.4, 4.4}, 0.9);
    for (double s : {-1.0, 1.0}) add_side(part, s, wider);
    add_roof(part, spine);
    part.rod({{0, -290, -83.5}, {0, -300, -78}}, {7.5, 5.5}, 0.9);
    part.rod({{0, -306, -74}, {0, -313, -68}}, {4.6, 4.0}, 0.8);
    part.rod({{0, -318, -63}, {0, -323, -57}}, {3.4, 2.6}, 0.8);
    return part;
}

} // namespace anatomy
