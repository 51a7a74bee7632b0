// Finds the point in the vessel that a mouse click selects.
#include "tools/centreline/fit/editor.hpp"
#include "tools/centreline/fit/tree_picture.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace crn::centreline
{
namespace
{

constexpr double beside_mm = 3.0; // a click this close beside the vessel still selects it

// Returns the depth towards the viewer at which the line of sight crosses the triangle, or NaN if they do not
// cross (Moeller and Trumbore 1997).
double meets(const Eigen::Vector3d &from, const Eigen::Vector3d &along, const Eigen::Vector3d &a,
             const Eigen::Vector3d &b, const Eigen::Vector3d &c)
{
    const Eigen::Vector3d ab = b - a, ac = c - a, p = along.cross(ac);
    const double determinant = ab.dot(p);
    if (std::abs(determinant) < 1e-12) return NAN;
    const Eigen::Vector3d s = from - a;
    const double u = s.dot(p) / determinant;
    const Eigen::Vector3d q = s.cross(ab);
    const double v = along.dot(q) / determinant;
    return u >= 0 && v >= 0 && u + v <= 1 ? ac.dot(q) / determinant : NAN;
}

} // namespace

std::optional<Eigen::Vector3d> picked(const Lumen &lumen, const View &view, double x, double y)
{
    const Eigen::Vector3d from = view.ray_start_mm(x, y), along = view.axes().row(2);
    const bake::Mesh &wall = lumen.wall();
    std::vector<double> depths;
    for (const bake::Triangle &t : wall.triangles) {
        const double depth =
            meets(from, along, wall.vertices_mm[t[0]], wall.vertices_mm[t[1]], wall.vertices_mm[t[2]]);
        if (std::isfinite(depth)) depths.push_back(depth);
    }
    std::sort(depths.rbegin(), depths.rend()); // nearest to the viewer first
    const Voxels &voxels = lumen.voxels();
    long voxel = -1;
    for (std::size_t i = 0; voxel < 0 && i + 1 < depths.size(); ++i)
        voxel = voxels.nearest(from + along * ((depths[i] + depths[i + 1]) / 2), voxels.voxel_mm());
    if (voxel < 0) { // beside the outline: take whatever lies nearest to the line of sight
        double nearest = beside_mm;
        for (std::size_t v = 0; v < voxels.size(); ++v) {
            const Eigen::Vector3d off = voxels.centre_mm(v) - from;
            const double distance = (off - along * along.dot(off)).norm();
            if (distance < nearest) nearest = distance, voxel = static_cast<long>(v);
        }
    }
    if (voxel < 0) return std::nullopt;
    return voxels.centre_mm(voxels.middle_near(static_cast<std::size_t>(voxel)));
}

} // namespace crn::centreline
