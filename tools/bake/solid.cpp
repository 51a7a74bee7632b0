// Uses OpenVDB's level sets to turn a mesh into a volume, to offset and subtract volumes, and to turn a
// volume into a mesh.
#include "tools/bake/solid.hpp"
#include "host/base/format.hpp"
#include "tools/bake/fault.hpp"
#include "tools/bake/level_set.hpp"

#include <openvdb/tools/Composite.h>
#include <openvdb/tools/VolumeToMesh.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace crn::bake
{
namespace
{

constexpr double band_voxels = 3;

void check_grid(const Mesh &mesh, double voxel_mm)
{
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d &v : mesh.vertices_mm) box.extend(v);
    const double voxels = (box.sizes() / voxel_mm).array().ceil().prod();
    if (voxels <= solid_voxels_max) return;
    const std::string text = formatted("a box of %.0f million voxels of %.2f mm, over %.0f", voxels * 1e-6,
                                       voxel_mm, solid_voxels_max * 1e-6);
    throw Fault(mesh.name + ": " + text + ": make solid_mm larger");
}

openvdb::FloatGrid::Ptr checked_level_set(const Mesh &mesh, double voxel_mm, double outside, double inside)
{
    check_grid(mesh, voxel_mm);
    return level_set(mesh, voxel_mm, 0, outside, inside);
}

Mesh surface_at(const openvdb::FloatGrid &grid, double distance_mm, const std::string &name)
{
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    std::vector<openvdb::Vec4I> quads;
    openvdb::tools::volumeToMesh(grid, points, triangles, quads, distance_mm, 0.0);
    Mesh mesh;
    mesh.name = name;
    for (const openvdb::Vec3s &p : points) mesh.vertices_mm.emplace_back(p.x(), p.y(), p.z());
    // OpenVDB lists the corners of a level set's faces clockwise as seen from outside.
    for (const openvdb::Vec3I &t : triangles) mesh.triangles.push_back({t[0], t[2], t[1]});
    for (const openvdb::Vec4I &q : quads) {
        mesh.triangles.push_back({q[0], q[2], q[1]});
        mesh.triangles.push_back({q[0], q[3], q[2]});
    }
    separate_sheets(mesh);
    return mesh;
}

// Corner c of triangle t has the number 3 t + c. Corners of different triangles are joined if they are to
// remain one vertex.
struct Corners {
    std::vector<std::uint32_t> parent;
    std::uint32_t root(std::uint32_t corner)
    {
        while (parent[corner] != corner) corner = parent[corner] = parent[parent[corner]];
        return corner;
    }
};

struct HalfEdge {
    std::uint32_t low, high, triangle, side;
    bool forward;
};

std::vector<HalfEdge> half_edges(const Mesh &mesh)
{
    std::vector<HalfEdge> edges;
    edges.reserve(3 * mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
            edges.push_back({std::min(a, b), std::max(a, b), t, k, a < b});
        }
    std::sort(edges.begin(), edges.end(), [](const HalfEdge &a, const HalfEdge &b) {
        return std::tie(a.low, a.high, a.forward, a.triangle) <
               std::tie(b.low, b.high, b.forward, b.triangle);
    });
    return edges;
}

// Joins the corners of two triangles at both ends of their common edge.
void join_across(Corners &corners, const HalfEdge &one, const HalfEdge &other)
{
    const auto corner = [](const HalfEdge &edge, bool low) {
        const bool first = edge.forward == low;
        return 3 * edge.triangle + (first ? edge.side : (edge.side + 1) % 3);
    };
    for (bool low : {true, false})
        corners.parent[corners.root(corner(one, low))] = corners.root(corner(other, low));
}

} // namespace

void separate_sheets(Mesh &mesh)
{
    Corners corners;
    corners.parent.resize(3 * mesh.triangles.size());
    std::iota(corners.parent.begin(), corners.parent.end(), 0u);
    const std::vector<HalfEdge> edges = half_edges(mesh);
    for (std::size_t i = 0, end; i < edges.size(); i = end) {
        for (end = i;
             end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high;)
            ++end;
        // Half edges that run backward come first, followed by as many that run forward; the n-th backward
        // one is paired with the n-th forward one.
        const std::size_t half = (end - i) / 2;
        for (std::size_t n = 0; n < half; ++n) join_across(corners, edges[i + n], edges[i + half + n]);
    }
    std::vector<std::uint32_t> vertex_of(corners.parent.size(), UINT32_MAX);
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Triangle> triangles = mesh.triangles;
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        for (std::uint32_t k = 0; k < 3; ++k) {
            std::uint32_t &vertex = vertex_of[corners.root(3 * t + k)];
            if (vertex == UINT32_MAX) {
                vertex = static_cast<std::uint32_t>(vertices.size());
                vertices.push_back(mesh.vertices_mm[mesh.triangles[t][k]]);
            }
            triangles[t][k] = vertex;
        }
    mesh.vertices_mm = std::move(vertices);
    mesh.triangles = std::move(triangles);
}

Mesh offset_surface(const Mesh &mesh, double voxel_mm, double offset_mm)
{
    const double reach = std::abs(offset_mm) / voxel_mm + band_voxels;
    const auto grid = checked_level_set(mesh, voxel_mm, offset_mm > 0 ? reach : band_voxels,
                                        offset_mm < 0 ? reach : band_voxels);
    Mesh made = surface_at(*grid, offset_mm, mesh.name);
    if (offset_mm >= 0 && (made.triangles.empty() || volume_mm3(made) <= 0))
        throw Fault(mesh.name + ": no solid comes of it: it is thinner than solid_mm = " +
                    std::to_string(voxel_mm) + ": make solid_mm smaller");
    return made;
}

Mesh closed_surface(const Mesh &mesh, double voxel_mm, double close_mm)
{
    return offset_surface(offset_surface(mesh, voxel_mm, close_mm), voxel_mm, -close_mm);
}

std::vector<InsideVoxel> inside_voxels(const Mesh &mesh, double voxel_mm)
{
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d &v : mesh.vertices_mm) box.extend(v);
    // No inner point of the box is deeper than half the box's thickness.
    const auto grid =
        checked_level_set(mesh, voxel_mm, band_voxels, box.sizes().minCoeff() / 2 / voxel_mm + band_voxels);
    std::vector<InsideVoxel> inside;
    for (auto value = grid->cbeginValueOn(); value; ++value) {
        const openvdb::Coord at = value.getCoord();
        if (*value < 0) inside.push_back({{at.x(), at.y(), at.z()}, -*value});
    }
    return inside;
}

Mesh clipped(const Mesh &mesh, const Eigen::AlignedBox3d &box, double voxel_mm)
{
    Mesh brick;
    brick.name = mesh.name;
    for (int i = 0; i < 8; ++i)
        brick.vertices_mm.push_back(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)));
    brick.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                       {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    auto rest = checked_level_set(mesh, voxel_mm, band_voxels, band_voxels);
    openvdb::tools::csgIntersection(*rest, *checked_level_set(brick, voxel_mm, band_voxels, band_voxels));
    Mesh made = surface_at(*rest, 0, mesh.name);
    if (made.triangles.empty()) throw Fault(mesh.name + ": nothing of it lies in clip_mm: check the corners");
    return made;
}

Mesh difference(const Mesh &mesh, const std::vector<const Mesh *> &taken, double voxel_mm, double gap_mm)
{
    auto rest = checked_level_set(mesh, voxel_mm, band_voxels, band_voxels);
    for (const Mesh *other : taken) {
        const Mesh blown = gap_mm > 0 ? offset_surface(*other, voxel_mm, gap_mm) : *other;
        openvdb::tools::csgDifference(*rest, *checked_level_set(blown, voxel_mm, band_voxels, band_voxels));
    }
    Mesh made = surface_at(*rest, 0, mesh.name);
    if (made.triangles.empty())
        throw Fault(mesh.name + ": nothing is left of it after `less`: check its place");
    return made;
}

} // namespace crn::bake
