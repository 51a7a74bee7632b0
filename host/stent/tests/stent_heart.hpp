// Makes a beating artery for tests and benchmarks of stents. The artery is 50 mm long and bent, and has a
// lesion that narrows it by 75 %. The displacements of the artery are given at the points of a lattice, as in
// the core. The artery moves as much as those of the shipped heart: 12 mm to and fro, 4 % of its length, 3.5
// % of its width, and 6 degrees of rotation; the artery also bends.
#pragma once
#include "host/model/motion.hpp"
#include "host/stent/vessel_wall.hpp"
#include "shared/scene/scene.h"
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

namespace crn
{

inline constexpr double artery_middle_mm = 25.0;

// Returns the displacement w of the lattice at a keyframe, in mm, from the present position to the reference
// pose.
inline Eigen::Vector3d artery_way_mm(const Eigen::Vector3d &x, int key)
{
    const double t = 2 * std::numbers::pi * key / motion_keyframes, s = std::sin(t), c = std::cos(t),
                 u = x.x() - artery_middle_mm;
    const Eigen::Vector3d moved(2 * s, 6 * s, 4 * (1 - c));
    const Eigen::Vector3d stretched(0.04 * s * u, 0.035 * s * x.y(), 0.035 * s * x.z());
    const Eigen::Vector3d turned(0, -0.1 * c * x.z(), 0.1 * c * x.y());
    const double bend = 0.008 * c;
    return moved + stretched + turned + Eigen::Vector3d(-bend * u * x.y(), bend * u * u / 2, 0);
}

// Stores the lattice's displacements as coefficients of the core's lattice.
struct BeatingLattice {
    std::vector<std::int16_t> rows;
    std::optional<Motion> motion;
    BeatingLattice()
    {
        constexpr int count[3] = {12, 8, 8};
        constexpr double spacing_mm = 7.8125, unit_mm = 0x1p-19 * 1e3;
        const Eigen::Vector3d origin(-17.5, -27.34375, -27.34375); // mm, before rounding
        crn_scene_motion scene{};
        scene.spacing_log2_q30 = 23;
        for (int k = 0; k < 3; ++k) {
            scene.origin_m_q30[k] = static_cast<std::int32_t>(std::lround(origin[k] * 1e-3 * 0x1p30));
            scene.node_count_xyz[k] = static_cast<std::uint16_t>(count[k]);
        }
        for (int z = 0; z < count[2]; ++z)
            for (int y = 0; y < count[1]; ++y)
                for (int x = 0; x < count[0]; ++x)
                    for (int axis = 0; axis < 3; ++axis) {
                        double w[motion_keyframes], c[motion_keyframes];
                        for (int key = 0; key < motion_keyframes; ++key)
                            w[key] =
                                artery_way_mm(origin + spacing_mm * Eigen::Vector3d(x, y, z), key)[axis] /
                                unit_mm;
                        motion_prefilter(w, c);
                        for (int i = 0; i < CRN_SCENE_MOTION_ROW; ++i)
                            rows.push_back(static_cast<std::int16_t>(std::lround(c[(i + 23) % 24])));
                    }
        scene.rows = rows.data();
        crn_scene moving{};
        moving.has_motion = true;
        moving.motion = scene;
        motion.emplace(moving);
    }
};

// Makes a bent artery of 50 mm along x, with a radius from 1.6 to 1.4 mm. If `is_diseased` is true, a lesion
// of 12 mm narrows the artery by 75 %.
inline VesselTree beating_artery(bool is_diseased)
{
    VesselBranch branch;
    branch.name = "LAD";
    VesselLesion lesion;
    lesion.name = "lesion_1";
    for (int i = 0; i <= 100; ++i) {
        const double s = 0.5 * i, bend = 0.02;
        const Eigen::Vector3d healthy(s, (s - artery_middle_mm) * (s - artery_middle_mm) * bend / 2, 0);
        const double radius = 1.6 - 0.004 * s, u = (s - artery_middle_mm) / 12;
        const bool is_in = is_diseased && std::abs(u) <= 0.5;
        const double lost = is_in ? 0.75 * (1 + std::cos(2 * std::numbers::pi * u)) / 2 : 0.0;
        branch.points_m.push_back((healthy + Eigen::Vector3d(0, 0, 0.4 * lost * radius)) * 1e-3);
        branch.radii_m.push_back(radius * (1 - lost) * 1e-3);
        if (!is_in) continue;
        if (lesion.healthy_radii_m.empty()) lesion.first_point = static_cast<std::size_t>(i);
        lesion.healthy_points_m.push_back(healthy * 1e-3);
        lesion.healthy_radii_m.push_back(radius * 1e-3);
    }
    VesselTree tree{{branch}};
    if (is_diseased) tree.lesions.push_back(lesion);
    return tree;
}

} // namespace crn
