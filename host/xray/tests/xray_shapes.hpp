// Makes closed meshes with known path lengths. The meshes are computed with sums, products and square roots
// only, so that every compiler gives equal results.
#pragma once
#include "host/model/bodies.hpp"
#include "host/xray/paths/carm.hpp"
#include <cmath>
#include <string>
#include <vector>

namespace crn
{

inline Eigen::Vector3i to_um(const Eigen::Vector3d &m)
{
    return {static_cast<int>(std::floor(m.x() * 1e6 + 0.5)), static_cast<int>(std::floor(m.y() * 1e6 + 0.5)),
            static_cast<int>(std::floor(m.z() * 1e6 + 0.5))};
}

// Makes an octahedron whose faces are divided into n x n triangles, and moves all vertices outwards to the
// sphere. It has 8 n^2 triangles.
inline Body sphere_body(const std::string &name, const std::string &material, int parent,
                        const Eigen::Vector3d &centre_m, double radius_m, int n)
{
    Body body{name, material, parent, {}, {}};
    for (int face = 0; face < 8; ++face) {
        const Eigen::Vector3d sign(face & 1 ? -1 : 1, face & 2 ? -1 : 1, face & 4 ? -1 : 1);
        const bool is_mirrored = (((face & 1) + (face >> 1 & 1) + (face >> 2 & 1)) & 1) != 0;
        auto add = [&](int i, int j) {
            Eigen::Vector3d at(i, j, n - i - j);
            at = at.cwiseProduct(sign) / std::sqrt(at.squaredNorm()) * radius_m + centre_m;
            body.vertices_um.push_back(to_um(at));
            return static_cast<std::uint32_t>(body.vertices_um.size() - 1);
        };
        auto triangle = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
            if (is_mirrored) std::swap(b, c);
            body.triangles.push_back({a, b, c});
        };
        for (int i = 0; i < n; ++i)
            for (int j = 0; i + j < n; ++j) {
                triangle(add(i, j), add(i + 1, j), add(i, j + 1));
                if (i + j < n - 1) triangle(add(i + 1, j), add(i + 1, j + 1), add(i, j + 1));
            }
    }
    return body;
}

// Returns the ray through the centre of a pixel; its origin is the source, and its direction a unit vector.
inline Eigen::Vector3d pixel_ray(const View &view, int x, int y)
{
    const double u = (x + 0.5 - view.size * 0.5) * view.pixel_m,
                 v = (view.size * 0.5 - y - 0.5) * view.pixel_m;
    return (view.right * u + view.up * v + view.forward * view.source_detector_m).normalized();
}

inline Body box_body(const std::string &name, const std::string &material, int parent,
                     const Eigen::Vector3d &low_m, const Eigen::Vector3d &high_m)
{
    Body body{name, material, parent, {}, {}};
    for (int corner = 0; corner < 8; ++corner)
        body.vertices_um.push_back(
            to_um({corner & 1 ? high_m.x() : low_m.x(), corner & 2 ? high_m.y() : low_m.y(),
                   corner & 4 ? high_m.z() : low_m.z()}));
    body.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return body;
}

} // namespace crn
