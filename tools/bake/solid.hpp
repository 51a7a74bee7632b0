// A body's surface made anew from a level set: pieces that overlap become one solid, cracks and faults of the
// mesh vanish, surfaces at a distance inside or outside come from the same field, and so do the voxels
// inside.
#pragma once
#include "tools/bake/mesh.hpp"

namespace crn::bake
{

constexpr double solid_voxels_max = 3e8; // of the box around a mesh: a finer level set would take minutes

// The closed surface `offset_mm` outside (negative: inside) that of the mesh, whose openings are capped, on a
// grid of `voxel_mm`. Flat details thinner than about a voxel are lost. Empty when nothing lies that deep.
// Throws Fault when the grid would be too large.
Mesh offset_surface(const Mesh &mesh, double voxel_mm, double offset_mm);

// Blown up by `close_mm` and shrunk again: hollows and gaps up to twice as wide are filled, the outside
// stays.
Mesh closed_surface(const Mesh &mesh, double voxel_mm, double close_mm);

// What of `mesh` lies in the box.
Mesh clipped(const Mesh &mesh, const Eigen::AlignedBox3d &box, double voxel_mm);

// What of `mesh` lies outside all of `taken`, each blown up by `gap_mm`.
Mesh difference(const Mesh &mesh, const std::vector<const Mesh *> &taken, double voxel_mm, double gap_mm);

// A voxel inside a closed mesh, and how far its middle, cell * voxel_mm, lies from the surface.
struct InsideVoxel {
    std::array<int, 3> cell;
    float depth_mm;
};
std::vector<InsideVoxel> inside_voxels(const Mesh &mesh, double voxel_mm);

// Vertices at which two sheets of a surface meet become two: afterwards every edge has two triangles.
void separate_sheets(Mesh &mesh);

} // namespace crn::bake
