#include "tools/anatomy/soft/tube_mesh.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace anatomy
{

namespace
{

Vec3 any_across(const Vec3 &direction)
{
    Vec3 axis = Vec3::Zero();
    Eigen::Index least;
    direction.cwiseAbs().minCoeff(&least);
    axis[least] = 1.0;
    return (axis - direction * direction.dot(axis)).normalized();
}

/* Keeps the points between `first` and `last` that lie too far from the straight line between them, in
 * position or radius (Douglas and Peucker 1973). */
void keep_far(const Curve &course, size_t first, size_t last, double error_mm, std::vector<bool> &kept)
{
    const Vec3 start = course[first].position_mm, axis = course[last].position_mm - start;
    double farthest = error_mm;
    size_t at = 0;
    for (size_t i = first + 1; i < last; i++) {
        const Vec3 offset = course[i].position_mm - start;
        const double share = std::clamp(offset.dot(axis) / std::max(axis.squaredNorm(), 1e-9), 0.0, 1.0);
        const double radius = std::lerp(course[first].radius_mm, course[last].radius_mm, share);
        const double off = std::max((offset - share * axis).norm(), std::abs(course[i].radius_mm - radius));
        if (off <= farthest) continue;
        farthest = off;
        at = i;
    }
    if (at == 0) return;
    kept[at] = true;
    keep_far(course, first, at, error_mm, kept);
    keep_far(course, at, last, error_mm, kept);
}

} // namespace

Curve simplified_course(const Curve &course, double error_mm)
{
    std::vector<bool> kept(course.size(), false);
    kept.front() = kept.back() = true;
    keep_far(course, 0, course.size() - 1, error_mm, kept);
    Curve fewer;
    for (size_t i = 0; i < course.size(); i++)
        if (kept[i]) fewer.push_back(course[i]);
    return fewer;
}

void add_tube(Mesh &mesh, const Curve &course, int sides)
{
    const double turn = 2.0 * std::numbers::pi / sides, same_area = std::sqrt(turn / std::sin(turn));
    const auto first = static_cast<uint32_t>(mesh.vertices_mm.size()), n = static_cast<uint32_t>(sides);
    Vec3 across = Vec3::Zero();
    for (size_t i = 0; i < course.size(); i++) {
        const Vec3 tangent = curve_tangent(course, i);
        across -= tangent * tangent.dot(across); // the section follows without twist
        across = across.norm() > 0.1 ? across.normalized() : any_across(tangent);
        const Vec3 other = tangent.cross(across);
        const double radius = same_area * course[i].radius_mm;
        for (int k = 0; k < sides; k++)
            mesh.vertices_mm.push_back(course[i].position_mm +
                                       radius * (std::cos(k * turn) * across + std::sin(k * turn) * other));
    }
    const auto last = static_cast<uint32_t>(mesh.vertices_mm.size()) - n;
    for (uint32_t k = 1; k + 1 < n; k++) {
        mesh.triangles.push_back({first, first + k + 1, first + k});
        mesh.triangles.push_back({last, last + k, last + k + 1});
    }
    for (uint32_t ring = first; ring < last; ring += n)
        for (uint32_t k = 0; k < n; k++) {
            const uint32_t a = ring + k, b = ring + (k + 1) % n;
            mesh.triangles.push_back({a, b, b + n});
            mesh.triangles.push_back({a, b + n, a + n});
        }
}

} // namespace anatomy
