// Provides a phantom for tests, a straight closed tube along the axis to the head, and scans of it that take
// little time.
#pragma once
#include "tools/lab/ct/instrument_scan.hpp"
#include "tools/lab/ct/scanner.hpp"
#include <cmath>

namespace crn::tests
{

inline bake::Mesh tube_mesh(double radius_mm, double low_mm, double high_mm, int sides = 96)
{
    bake::Mesh mesh;
    mesh.name = "tube";
    for (const double y : {low_mm, high_mm}) {
        for (int i = 0; i < sides; ++i) {
            const double angle = 2 * M_PI * i / sides;
            mesh.vertices_mm.emplace_back(radius_mm * std::sin(angle), y, radius_mm * std::cos(angle));
        }
        mesh.vertices_mm.emplace_back(0, y, 0);
    }
    const auto n = static_cast<std::uint32_t>(sides), top = n + 1;
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t j = (i + 1) % n;
        mesh.triangles.insert(
            mesh.triangles.end(),
            {{i, j, top + i}, {j, top + j, top + i}, {j, i, n}, {top + i, top + j, top + n}});
    }
    return mesh;
}

inline ct::ScannerSettings quick_scanner(double half_side_mm, double low_mm, double high_mm)
{
    ct::ScannerSettings settings;
    settings.views = 300;
    settings.box_mm = {Eigen::Vector3d(-half_side_mm, low_mm, -half_side_mm),
                       Eigen::Vector3d(half_side_mm, high_mm, half_side_mm)};
    return settings;
}

inline void no_report(const std::string &, double) {}

} // namespace crn::tests
