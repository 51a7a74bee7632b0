/* The measures of every level of the spine, and the frame in which a vertebra is built. */
#pragma once
#include "tools/anatomy/skeleton.hpp"
#include <array>
#include <numbers>

namespace anatomy
{

/* Holds the published or assumed measures of one vertebra of a man 1.78 m tall. Sources stand beside the
 * table in levels.cpp. */
struct SpineLevel {
    const char *name;
    double height_mm, wedge_mm;                 // of the body; how much higher its front is than its back
    double width_mm, depth_mm, lower_ratio;     // of the body; width of its lower over its upper end plate
    double disc_below_mm;                       //
    double pedicle_width_mm, pedicle_height_mm; //
    double pedicle_angle_deg;                   // the pedicles converge to the front
    double canal_width_mm, canal_depth_mm;      //
    double transverse_span_mm;                  // from tip to tip
    double spinous_slope_deg, spinous_mm;   // below the vertebra's own horizontal; length behind the canal
    double facet_x_mm, facet_behind_mm;     // the joint with the vertebra above: from the midplane, and
                                            // behind the back of the body
    double facet_angle_deg, facet_tilt_deg; // the joint's plane from the midplane; its tilt to the front
};

constexpr double DEGREE = std::numbers::pi / 180.0; // in radians
constexpr size_t SPINE_LEVELS = 24, C2 = 1, C7 = 6, T1 = 7, T12 = 18, L1 = 19, L5 = 23;

const std::array<SpineLevel, SPINE_LEVELS> &levels();

/* The left hip centre of a man, and how much wider a woman's pelvis is: 280 mm for a stature of 1.78 m, and
 * 275 mm for one of 1.65 m. */
inline const Vec3 HIP_MM(86, -300, -12);
constexpr double WOMAN_PELVIS_WIDER = 1.055;

struct Frame {
    Vec3 centre;
    Eigen::Matrix3d rotation; // columns: left, up, front
    Vec3 at(double x, double y, double z) const { return centre + rotation * Vec3(x, y, z); }
    Vec3 along(double x, double y, double z) const { return rotation * Vec3(x, y, z); }
};

Frame frame_of(const Vertebra &vertebra);

/* Describes one joint between two vertebrae on the patient's left (s = 1) or right (s = -1). `normal` points
 * from the lower vertebra's process to the upper one's. */
struct FacetJoint {
    Vec3 centre;
    Eigen::Matrix3d rotation; // columns: along the joint, up, normal
};

/* Returns the joint between the vertebra `index` and the one above it. For index = SPINE_LEVELS, the function
 * returns the joint between L5 and the sacrum. */
FacetJoint facet_joint(const std::vector<Vertebra> &spine, size_t index, double s);

Part vertebra_part(const std::vector<Vertebra> &spine, size_t index, const SkeletonShape &shape); // T1 to L5
Part cervical_part(const std::vector<Vertebra> &spine, size_t index);                             // C1 to C7
Part sternum_part();
Part sacrum_part(const std::vector<Vertebra> &spine, const SkeletonShape &shape); // with coccyx

} // namespace anatomy
