// Turns tapered capsules into a closed mesh: computes distances on a grid near the wall and passes them to
// OpenVDB's volumeToMesh.
#include "tools/bake/centreline.hpp"
#include "tools/bake/fault.hpp"
#include "tools/bake/vdb.hpp"
#include "tools/mesh/files/mesh_file.hpp"

#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tools/VolumeToMesh.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace crn::bake
{
namespace
{

constexpr int block_edge = 8;
constexpr double band_voxels = 3.0;
constexpr std::size_t blocks_max = 2'000'000; // about 1 billion voxels are examined

struct Capsule {
    Eigen::Vector3d a, b;
    double radius_a, radius_b;
    double distance(const Eigen::Vector3d &p) const
    {
        return tapered_capsule_distance(p, a, radius_a, b, radius_b);
    }
};

std::vector<Capsule> capsules_of(const std::vector<Centreline> &lines)
{
    std::vector<Capsule> capsules;
    for (const Centreline &line : lines)
        for (std::size_t i = 0; i + 1 < line.points_mm.size(); ++i)
            capsules.push_back(
                {line.points_mm[i], line.points_mm[i + 1], line.radii_mm[i], line.radii_mm[i + 1]});
    return capsules;
}

using BlockKey = std::array<int, 3>;
using Blocks = std::map<BlockKey, std::vector<std::uint32_t>>;

// Lists which capsules may reach into which block of voxels.
Blocks blocks_of(const std::vector<Capsule> &capsules, double voxel_mm)
{
    Blocks blocks;
    const double edge = block_edge * voxel_mm, band = band_voxels * voxel_mm;
    for (std::uint32_t i = 0; i < capsules.size(); ++i) {
        const Capsule &c = capsules[i];
        const double reach = std::max(c.radius_a, c.radius_b) + band;
        const Eigen::Vector3d low = (c.a.cwiseMin(c.b).array() - reach) / edge,
                              high = (c.a.cwiseMax(c.b).array() + reach) / edge;
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

// Computes the distances in one block if the wall is near that block.
void fill_block(const BlockKey &key, const std::vector<Capsule> &capsules,
                const std::vector<std::uint32_t> &candidates, double voxel_mm,
                openvdb::FloatGrid::Accessor &out)
{
    const Eigen::Vector3d corner = Eigen::Vector3d(key[0], key[1], key[2]) * (block_edge * voxel_mm);
    const Eigen::Vector3d centre = corner.array() + block_edge * voxel_mm / 2;
    const double half = block_edge * voxel_mm * std::sqrt(3.0) / 2, band = band_voxels * voxel_mm;
    double nearest = INFINITY;
    std::vector<double> at_centre;
    for (std::uint32_t i : candidates) {
        at_centre.push_back(capsules[i].distance(centre));
        nearest = std::min(nearest, at_centre.back());
    }
    if (std::abs(nearest) > half + band) return;
    std::vector<const Capsule *> close;
    for (std::size_t i = 0; i < candidates.size(); ++i)
        if (at_centre[i] <= nearest + 2 * half) close.push_back(&capsules[candidates[i]]);
    for (int n = 0; n < block_edge * block_edge * block_edge; ++n) {
        const openvdb::Coord at(key[0] * block_edge + n % 8, key[1] * block_edge + n / 8 % 8,
                                key[2] * block_edge + n / 64);
        const Eigen::Vector3d p = Eigen::Vector3d(at.x(), at.y(), at.z()) * voxel_mm;
        double distance = INFINITY;
        for (const Capsule *capsule : close) distance = std::min(distance, capsule->distance(p));
        if (std::abs(distance) < band) out.setValue(at, static_cast<float>(distance));
    }
}

Mesh to_mesh(const openvdb::FloatGrid &grid)
{
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    std::vector<openvdb::Vec4I> quads;
    openvdb::tools::volumeToMesh(grid, points, triangles, quads, 0.0, 0.0);
    Mesh mesh;
    mesh.name = "surface of the centrelines";
    for (const openvdb::Vec3s &p : points) mesh.vertices_mm.emplace_back(p.x(), p.y(), p.z());
    for (const openvdb::Vec3I &t : triangles) mesh.triangles.push_back({t[0], t[1], t[2]});
    for (const openvdb::Vec4I &q : quads) {
        mesh.triangles.push_back({q[0], q[1], q[2]});
        mesh.triangles.push_back({q[0], q[2], q[3]});
    }
    return mesh;
}

} // namespace

Mesh surface_of(const std::vector<Centreline> &lines, double voxel_mm, Progress &progress)
{
    start_openvdb();
    const std::vector<Capsule> capsules = capsules_of(lines);
    const Blocks blocks = blocks_of(capsules, voxel_mm);
    auto grid = openvdb::FloatGrid::create(static_cast<float>(band_voxels * voxel_mm));
    grid->setTransform(openvdb::math::Transform::createLinearTransform(voxel_mm));
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    auto out = grid->getAccessor();
    progress.stage("making the surface of the centrelines", blocks.size());
    std::size_t done = 0;
    for (const auto &[key, candidates] : blocks) {
        fill_block(key, capsules, candidates, voxel_mm, out);
        if (++done % 256 == 0) progress.step(done);
    }
    openvdb::tools::signedFloodFill(grid->tree());
    progress.finish();
    Mesh mesh = to_mesh(*grid);
    if (mesh.triangles.size() > mesh_triangles_max)
        throw Fault("the surface of the centrelines has " + std::to_string(mesh.triangles.size()) +
                    " triangles, over " + std::to_string(mesh_triangles_max) + ": make surface_mm larger");
    weld(mesh);
    return mesh;
}

} // namespace crn::bake
