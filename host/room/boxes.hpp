// Computes the gap between two boxes at any angle by the method of separating axes (Gottschalk 1996). The gap
// is the largest distance between the projections of the two boxes on fifteen axes. The computed gap never
// exceeds the true distance, and is negative when the boxes overlap.
#pragma once
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace crn
{

struct Box {
    Eigen::Vector3d centre;
    std::array<Eigen::Vector3d, 3> axes; // unit vectors at right angles
    Eigen::Vector3d half;                // half widths along the axes
};

inline double gap_along(const Box &a, const Box &b, const Eigen::Vector3d &axis)
{
    double reach = 0.0;
    for (int i = 0; i < 3; ++i)
        reach += a.half[i] * std::fabs(a.axes[i].dot(axis)) + b.half[i] * std::fabs(b.axes[i].dot(axis));
    return std::fabs((b.centre - a.centre).dot(axis)) - reach;
}

inline double gap_between(const Box &a, const Box &b)
{
    double gap = -1e9;
    for (int i = 0; i < 3; ++i) gap = std::max({gap, gap_along(a, b, a.axes[i]), gap_along(a, b, b.axes[i])});
    for (const Eigen::Vector3d &first : a.axes)
        for (const Eigen::Vector3d &second : b.axes) {
            const Eigen::Vector3d across = first.cross(second);
            const double square = across.squaredNorm();
            if (square < 1e-12) continue; // parallel edges: the faces' axes cover this case
            gap = std::max(gap, gap_along(a, b, across / std::sqrt(square)));
        }
    return gap;
}

} // namespace crn
