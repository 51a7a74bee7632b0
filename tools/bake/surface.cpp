// Converts tapered capsules to a closed mesh: computes distances on a grid near the wall, and takes the
// surface of zero distance.
#include "host/base/format.hpp"
#include "tools/bake/centreline.hpp"
#include "tools/bake/fault.hpp"
#include "tools/bake/triangle_tree.hpp"
#include "tools/mesh/files/mesh_file.hpp"
#include "tools/mesh/level_set/level_set.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace crn::bake
{
namespace
{

using mesh::block_edge;
constexpr double surface_band_voxels = 3.0;
constexpr double surface_voxel_min_mm = 0.1;  // the least surface_mm that a scene's text may state
constexpr std::size_t blocks_max = 2'000'000; // about 1 billion voxels are examined

using centreline::Sphere;

struct Capsule {
    Sphere a, b;
    double distance(const Eigen::Vector3d &p) const
    {
        return tapered_capsule_distance(p, a.centre_mm, a.radius_mm, b.centre_mm, b.radius_mm);
    }
};

std::vector<Capsule> capsules_of(const std::vector<Curve> &lines)
{
    std::vector<Capsule> capsules;
    for (const Curve &line : lines)
        for (std::size_t i = 0; i + 1 < line.spheres.size(); ++i)
            capsules.push_back({line.spheres[i], line.spheres[i + 1]});
    return capsules;
}

using BlockKey = mesh::Cell;
using Blocks = std::map<BlockKey, std::vector<std::uint32_t>>;

// Returns, for each block of voxels, the capsules that may reach into the block.
Blocks blocks_of(const std::vector<Capsule> &capsules, double voxel_mm)
{
    Blocks blocks;
    const double edge = block_edge * voxel_mm, band = surface_band_voxels * voxel_mm;
    for (std::uint32_t i = 0; i < capsules.size(); ++i) {
        const Capsule &c = capsules[i];
        const double reach = std::max(c.a.radius_mm, c.b.radius_mm) + band;
        const Eigen::Vector3d low = (c.a.centre_mm.cwiseMin(c.b.centre_mm).array() - reach) / edge,
                              high = (c.a.centre_mm.cwiseMax(c.b.centre_mm).array() + reach) / edge;
        BlockKey k;
        for (k[2] = static_cast<int>(std::floor(low[2])); k[2] <= high[2]; ++k[2])
            for (k[1] = static_cast<int>(std::floor(low[1])); k[1] <= high[1]; ++k[1])
                for (k[0] = static_cast<int>(std::floor(low[0])); k[0] <= high[0]; ++k[0])
                    blocks[k].push_back(i);
        if (blocks.size() > blocks_max)
            throw Fault("the centrelines need over " + std::to_string(blocks_max) + " blocks of voxels of " +
                        std::to_string(voxel_mm) + " mm: make surface_mm larger");
    }
    return blocks;
}

// Computes the distances in one block if the wall is near that block. Otherwise returns false.
bool fill_block(const BlockKey &key, const std::vector<Capsule> &capsules,
                const std::vector<std::uint32_t> &candidates, double voxel_mm, mesh::Block &distances)
{
    const Eigen::Vector3d corner = Eigen::Vector3d(key[0], key[1], key[2]) * (block_edge * voxel_mm);
    const Eigen::Vector3d centre = corner.array() + block_edge * voxel_mm / 2;
    const double half = block_edge * voxel_mm * std::sqrt(3.0) / 2, band = surface_band_voxels * voxel_mm;
    double nearest = INFINITY;
    std::vector<double> at_centre;
    for (std::uint32_t i : candidates) {
        at_centre.push_back(capsules[i].distance(centre));
        nearest = std::min(nearest, at_centre.back());
    }
    if (std::abs(nearest) > half + band) return false;
    std::vector<const Capsule *> close;
    for (std::size_t i = 0; i < candidates.size(); ++i)
        if (at_centre[i] <= nearest + 2 * half) close.push_back(&capsules[candidates[i]]);
    for (int n = 0; n < static_cast<int>(distances.size()); ++n) {
        const Eigen::Vector3d p =
            Eigen::Vector3d(key[0] * block_edge + n % 8, key[1] * block_edge + n / 8 % 8,
                            key[2] * block_edge + n / 64) *
            voxel_mm;
        distances[n] = INFINITY;
        for (const Capsule *capsule : close) distances[n] = std::min(distances[n], capsule->distance(p));
    }
    return true;
}

} // namespace

Mesh surface_of(const std::vector<Curve> &lines, double voxel_mm, Progress &progress)
{
    const std::vector<Capsule> capsules = capsules_of(lines);
    const Blocks blocks = blocks_of(capsules, voxel_mm);
    mesh::LevelSet level(voxel_mm, surface_band_voxels * voxel_mm);
    progress.stage("making the surface of the centrelines", blocks.size());
    std::size_t done = 0;
    mesh::Block distances;
    for (const auto &[key, candidates] : blocks) {
        if (fill_block(key, capsules, candidates, voxel_mm, distances)) level.set_near(key, distances);
        if (++done % 256 == 0) progress.step(done);
    }
    level.fill_signs();
    progress.finish();
    const mesh::QuadSurface surface = level.surface();
    Mesh mesh{"surface of the centrelines", surface.vertices, mesh::divided(surface), {}};
    if (mesh.triangles.size() > mesh_triangles_max)
        throw Fault("the surface of the centrelines has " + std::to_string(mesh.triangles.size()) +
                    " triangles, over " + std::to_string(mesh_triangles_max) + ": make surface_mm larger");
    weld(mesh);
    return mesh;
}

std::string narrowing_warning(const Mesh &surface, const std::vector<Curve> &lines, double voxel_mm)
{
    constexpr double share_max = 0.02, step_mm = 0.05;
    const TriangleTree wall(surface);
    double worst = 0.0, inside_mm = 0.0;
    Sphere place{Eigen::Vector3d::Zero(), 0.0};
    for (const Curve &line : lines)
        for (const Sphere &sphere : line.spheres) {
            // The round ends of a curve are not what its author means by the vessel's width.
            const double end_mm = std::min((sphere.centre_mm - line.spheres.front().centre_mm).norm(),
                                           (sphere.centre_mm - line.spheres.back().centre_mm).norm());
            if (end_mm < sphere.radius_mm) continue;
            const double lost_mm = sphere.radius_mm + wall.nearest(sphere.centre_mm).distance_mm;
            if (lost_mm <= worst * sphere.radius_mm) continue;
            worst = lost_mm / sphere.radius_mm;
            inside_mm = lost_mm;
            place = sphere;
        }
    if (worst <= share_max) return "";
    const double holds_mm = step_mm * std::floor(voxel_mm * std::sqrt(share_max / worst) / step_mm);
    std::string remedy = formatted("surface_mm = %.2f in [lumen] would hold it to 2 %%", holds_mm);
    if (holds_mm < surface_voxel_min_mm)
        remedy = formatted("state surface_mm = %.1f in [lumen], the finest one", surface_voxel_min_mm);
    return formatted(
        "warning: the surface of voxels of %.2f mm is %.3f mm inside the radius of %.2f mm that the "
        "centreline has at %s (%.1f %%), so the vessel is too narrow there: %s\n",
        voxel_mm, inside_mm, place.radius_mm, place_text(place.centre_mm).c_str(), 100 * worst,
        remedy.c_str());
}

} // namespace crn::bake
