// Makes CT volumes of simple shapes. A voxel on a border holds the mean of its content.
#pragma once
#include "host/model/ct_volume.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{

// Makes a volume of air whose middle is the origin.
inline CtVolume air_volume(const std::array<int, 3> &size, const Eigen::Vector3d &spacing_mm)
{
    CtVolume volume;
    volume.size = size;
    volume.spacing_mm = spacing_mm;
    for (int axis = 0; axis < 3; ++axis) volume.first_mm[axis] = -0.5 * (size[axis] - 1) * spacing_mm[axis];
    volume.permille.assign(volume.count(), 0);
    return volume;
}

// Fills each voxel with `permille` in proportion to share(middle of the voxel in mm); what was there remains
// in the rest.
template <class Share> void fill(CtVolume &volume, double permille, const Share &share)
{
    for (int y = 0; y < volume.size[1]; ++y)
        for (int z = 0; z < volume.size[2]; ++z)
            for (int x = 0; x < volume.size[0]; ++x) {
                const Eigen::Vector3d at_mm =
                    volume.first_mm + volume.spacing_mm.cwiseProduct(Eigen::Vector3d(x, y, z));
                const double part = share(at_mm);
                if (part <= 0.0) continue;
                std::uint16_t &value = volume.permille[volume.index(x, y, z)];
                value = static_cast<std::uint16_t>(std::floor(part * permille + (1.0 - part) * value + 0.5));
            }
}

inline void fill_sphere(CtVolume &volume, double permille, const Eigen::Vector3d &centre_mm, double radius_mm)
{
    const double voxel_mm = std::cbrt(volume.spacing_mm.prod());
    fill(volume, permille, [&](const Eigen::Vector3d &at_mm) {
        return std::clamp(0.5 + (radius_mm - (at_mm - centre_mm).norm()) / voxel_mm, 0.0, 1.0);
    });
}

inline void fill_box(CtVolume &volume, double permille, const Eigen::Vector3d &low_mm,
                     const Eigen::Vector3d &high_mm)
{
    fill(volume, permille, [&](const Eigen::Vector3d &at_mm) {
        double part = 1.0;
        for (int axis = 0; axis < 3; ++axis) {
            const double half = 0.5 * volume.spacing_mm[axis];
            const double covered =
                std::min(at_mm[axis] + half, high_mm[axis]) - std::max(at_mm[axis] - half, low_mm[axis]);
            part *= std::clamp(covered / (2.0 * half), 0.0, 1.0);
        }
        return part;
    });
}

// Thousandths of water at a point of the trunk, in mm from its middle.
inline double trunk_permille(double x, double y, double z)
{
    const double skin = (x / 172) * (x / 172) + (z / 118) * (z / 118);
    if (skin > 1.0) return 0;
    const double inner = (x / 152) * (x / 152) + (z / 98) * (z / 98);
    if (inner > 1.0) return 905; // fat
    const double spine = std::hypot(x, z + 70);
    if (spine < 20) return std::fabs(std::fmod(y + 400, 32.0) - 16) < 13 ? (spine > 18 ? 1700 : 1180) : 1050;
    const double rib = std::fmod(y + 400 + 0.4 * z, 30.0);
    if (inner > 0.88 && rib < 9) return rib > 2 && rib < 7 && inner > 0.91 && inner < 0.97 ? 1150 : 1600;
    const double lung = std::pow((std::fabs(x) - 78) / 58, 2) + (z / 78) * (z / 78);
    return lung < 1.0 && y > -60 ? 180 : 1050;
}

// Makes a trunk of edge^3 voxels with fat, lungs, spine, ribs and noise, for benchmarks.
inline CtVolume trunk_volume(int edge, double voxel_mm)
{
    CtVolume volume = air_volume({edge, edge, edge}, Eigen::Vector3d::Constant(voxel_mm));
    std::uint32_t state = 1;
    for (int y = 0; y < edge; ++y)
        for (int z = 0; z < edge; ++z)
            for (int x = 0; x < edge; ++x) {
                const Eigen::Vector3d at_mm = volume.first_mm + voxel_mm * Eigen::Vector3d(x, y, z);
                const double value = trunk_permille(at_mm.x(), at_mm.y(), at_mm.z());
                state = state * 1664525u + 1013904223u;
                if (value > 0.0)
                    volume.permille[volume.index(x, y, z)] =
                        static_cast<std::uint16_t>(value + (state >> 26));
            }
    return volume;
}

} // namespace crn
