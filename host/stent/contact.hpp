// Computes the contact of struts with the triangles of the wall, by libccd. A strut is a capsule. Tissue of
// some depth lies behind each triangle, so that a strut is always pushed back towards the blood.
#pragma once
#include <Eigen/Core>
#include <array>

namespace crn
{

struct StrutCapsule {
    Eigen::Vector3d from_mm, to_mm;
    double radius_mm = 0.0;
};

struct StrutContact {
    double depth_mm = 0.0;     // distance by which it has to be moved ...
    Eigen::Vector3d direction; // ... in this direction (unit) to lie on the blood side of the wall
};

inline constexpr double tissue_depth_mm = 1.0;

// `outward` is the unit normal of the triangle, and points away from the blood. A depth of 0 means that the
// strut does not touch the triangle.
StrutContact strut_contact(const StrutCapsule &strut, const std::array<Eigen::Vector3d, 3> &corners_mm,
                           const Eigen::Vector3d &outward);

} // namespace crn
