// Makes vessels for tests and benchmarks of stents: beating tubes of any cross-section around a curve, and
// balloons that fill these tubes. Another function of this file measures how deep struts lie in the wall,
// without the shortcuts of the program's own computation. Lengths in mm.
#pragma once
#include "host/model/motion.hpp"
#include "host/stent/contact.hpp"
#include "host/stent/figures.hpp"
#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>

namespace crn
{

// Makes a tube of `length_mm` that starts at x = 0 along x, bends in the plane of x and y with
// `curvature_per_mm`, and is closed at both ends.
struct TestVessel {
    double length_mm = 40.0, radius_mm = 1.5, curvature_per_mm = 0.0;
    double eccentricity = 0.0; // of the section: semi-axes r (1 + e) and r (1 - e)
    int around = 24, along = 80;
    std::vector<WallTriangle> triangles;
    std::vector<Eigen::Vector3d> vertices_mm;

    Eigen::Vector3d middle(double s) const
    {
        const double k = curvature_per_mm;
        return k == 0 ? Eigen::Vector3d(s, 0, 0)
                      : Eigen::Vector3d(std::sin(k * s) / k, (1 - std::cos(k * s)) / k, 0);
    }
    Eigen::Vector3d across(double s) const
    {
        return {-std::sin(curvature_per_mm * s), std::cos(curvature_per_mm * s), 0};
    }
    void make()
    {
        const auto ring = [&](int i) { return static_cast<std::uint32_t>(i * around); };
        for (int i = 0; i <= along; ++i)
            for (int k = 0; k < around; ++k) {
                const double s = length_mm * i / along,
                             angle = 2 * std::numbers::pi * (k + 0.5 * (i % 2)) / around;
                // A circle with the given radius is inscribed in the polygon of the tube's cross-section.
                const double r = radius_mm / std::cos(std::numbers::pi / around);
                vertices_mm.push_back(middle(s) + r * (1 + eccentricity) * std::cos(angle) * across(s) +
                                      Eigen::Vector3d(0, 0, r * (1 - eccentricity) * std::sin(angle)));
            }
        for (int i = 0; i < along; ++i)
            for (int k = 0; k < around; ++k) {
                const auto a = static_cast<std::uint32_t>(k),
                           b = static_cast<std::uint32_t>((k + 1) % around);
                const std::uint32_t p = ring(i), q = ring(i + 1);
                if (i % 2 == 0) {
                    triangles.push_back({p + a, p + b, q + a});
                    triangles.push_back({p + b, q + b, q + a});
                } else {
                    triangles.push_back({p + a, q + b, q + a});
                    triangles.push_back({p + a, p + b, q + b});
                }
            }
        for (int end : {0, along}) {
            vertices_mm.push_back(middle(end == 0 ? 0.0 : length_mm));
            const auto tip = static_cast<std::uint32_t>(vertices_mm.size() - 1);
            for (int k = 0; k < around; ++k) {
                const std::uint32_t a = ring(end) + static_cast<std::uint32_t>(k),
                                    b = ring(end) + static_cast<std::uint32_t>((k + 1) % around);
                triangles.push_back(end == 0 ? WallTriangle{tip, b, a} : WallTriangle{tip, a, b});
            }
        }
    }
    using Map = std::function<Eigen::Vector3d(const Eigen::Vector3d &)>;
    std::vector<Eigen::Vector3i> vertices_um(const Map &map) const
    {
        std::vector<Eigen::Vector3i> result;
        for (const Eigen::Vector3d &v : vertices_mm)
            result.push_back((map(v) * 1e3).array().round().matrix().cast<int>());
        return result;
    }
    static Eigen::Vector3d still(const Eigen::Vector3d &x) { return x; }
};

// Makes a balloon of `length` on the centreline of the vessel, with its middle at the position `at` along the
// vessel. The arc length along the balloon's tool increases along the vessel.
inline BalloonPose balloon_in(const TestVessel &vessel, double at_mm, double length_mm, double radius_mm,
                              const TestVessel::Map &map = TestVessel::still)
{
    BalloonPose pose;
    const int balls = static_cast<int>(length_mm) + 1;
    for (int i = 0; i < balls; ++i) {
        const double s = at_mm - length_mm / 2 + length_mm * i / (balls - 1);
        pose.points.push_back({s, map(vessel.middle(s)), radius_mm});
    }
    return pose;
}

// Returns the largest depth to which any strut reaches into any triangle. For every pair of strut and
// triangle this function calls libccd. The function uses none of the program's shortcuts: the grid, the list
// of near triangles, and the test of planes.
inline double deepest_strut_mm(const Stent &stent, const StentWall &wall)
{
    double deepest = 0.0;
    for (std::size_t i = 0; i < stent.lattice().struts.size(); ++i) {
        const auto [a, b] = stent.lattice().struts[i];
        const Eigen::Vector3d middle = stent.strut_middle_mm(i);
        for (std::uint32_t end : {a, b}) {
            const StrutCapsule capsule{stent.points()[end].place_mm, middle,
                                       stent.design().strut_thickness_mm / 2};
            const double reach = (capsule.to_mm - capsule.from_mm).norm() + 2.0;
            for (std::size_t t = 0; t < wall.triangle_count(); ++t) {
                if ((wall.corner_mm(t, 0) - capsule.from_mm).squaredNorm() > reach * reach)
                    continue; // too far away to matter
                deepest = std::max(
                    deepest,
                    strut_contact(capsule, {wall.corner_mm(t, 0), wall.corner_mm(t, 1), wall.corner_mm(t, 2)},
                                  wall.normal(t))
                        .depth_mm);
            }
        }
    }
    return deepest;
}

} // namespace crn
