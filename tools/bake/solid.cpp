// Uses level sets (tools/mesh/level_set) to offset, clip and subtract bodies and to remake their surfaces.
#include "tools/bake/solid.hpp"
#include "host/base/format.hpp"
#include "tools/bake/fault.hpp"

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

Eigen::AlignedBox3d box_of(const Mesh &mesh)
{
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d &v : mesh.vertices_mm) box.extend(v);
    return box;
}

Eigen::AlignedBox3d widened(const Eigen::AlignedBox3d &box, double by_mm)
{
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(by_mm);
    return {box.min() - margin, box.max() + margin};
}

void check_grid(const Mesh &mesh, double voxel_mm)
{
    const Eigen::AlignedBox3d box = box_of(mesh);
    const double voxels = (box.sizes() / voxel_mm).array().ceil().prod();
    if (voxels <= solid_voxels_max) return;
    const std::string text = formatted("a box of %.0f million voxels of %.2f mm, over %.0f", voxels * 1e-6,
                                       voxel_mm, solid_voxels_max * 1e-6);
    throw Fault(mesh.name + ": " + text + ": make solid_mm larger");
}

mesh::LevelSet checked_level_set(const Mesh &mesh, double voxel_mm, double outside, double inside)
{
    check_grid(mesh, voxel_mm);
    return level_set(mesh, voxel_mm, 0, outside, inside);
}

Mesh surface_at(const mesh::LevelSet &level, double distance_mm, const std::string &name)
{
    const mesh::QuadSurface surface = level.surface(distance_mm);
    Mesh mesh{name, surface.vertices, mesh::divided(surface), {}};
    mesh::separate_sheets(mesh.vertices_mm, mesh.triangles);
    return mesh;
}

} // namespace

mesh::LevelSet level_set(const Mesh &mesh, double voxel_mm, double place, double outside, double inside)
{
    return {mesh.vertices_mm, mesh.triangles, voxel_mm, place, outside, inside};
}

Mesh offset_surface(const Mesh &mesh, double voxel_mm, double offset_mm)
{
    const double reach = std::abs(offset_mm) / voxel_mm + band_voxels;
    const auto grid = checked_level_set(mesh, voxel_mm, offset_mm > 0 ? reach : band_voxels,
                                        offset_mm < 0 ? reach : band_voxels);
    Mesh made = surface_at(grid, offset_mm, mesh.name);
    if (offset_mm >= 0 && (made.triangles.empty() || volume_mm3(made) <= 0))
        throw Fault(mesh.name + ": no solid comes of it: it is thinner than solid_mm = " +
                    std::to_string(voxel_mm) + ": make solid_mm smaller");
    return made;
}

Mesh closed_surface(const Mesh &mesh, double voxel_mm, double close_mm)
{
    return offset_surface(offset_surface(mesh, voxel_mm, close_mm), voxel_mm, -close_mm);
}

std::vector<mesh::InsideVoxel> inside_voxels(const Mesh &mesh, double voxel_mm)
{
    const Eigen::AlignedBox3d box = box_of(mesh);
    // No point inside the mesh is deeper than half the smallest dimension of the mesh's bounding box.
    const double deepest = box.sizes().minCoeff() / 2 / voxel_mm + band_voxels;
    return checked_level_set(mesh, voxel_mm, band_voxels, deepest).inside();
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
    rest.intersect(checked_level_set(brick, voxel_mm, band_voxels, band_voxels));
    Mesh made = surface_at(rest, 0, mesh.name);
    if (made.triangles.empty()) throw Fault(mesh.name + ": nothing of it lies in clip_mm: check the corners");
    return made;
}

Mesh difference(const Mesh &mesh, const std::vector<const Mesh *> &taken, double voxel_mm, double gap_mm)
{
    auto rest = checked_level_set(mesh, voxel_mm, band_voxels, band_voxels);
    const double reach_mm = gap_mm + 2 * band_voxels * voxel_mm;
    const Eigen::AlignedBox3d near = widened(box_of(mesh), reach_mm);
    for (const Mesh *other : taken) {
        if (!near.intersects(box_of(*other))) continue;
        auto cut = checked_level_set(*other, voxel_mm, band_voxels + gap_mm / voxel_mm, band_voxels);
        // A distance less the gap is the distance to the surface that is expanded by the gap.
        if (gap_mm > 0) cut.expand(gap_mm);
        rest.subtract(std::move(cut));
    }
    Mesh made = surface_at(rest, 0, mesh.name);
    if (made.triangles.empty())
        throw Fault(mesh.name + ": nothing is left of it after `less`: check its place");
    return made;
}

} // namespace crn::bake
