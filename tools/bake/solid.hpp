// Remakes a body's surface from a level set. Overlapping pieces become one solid, and cracks and faults of
// the mesh vanish. Surfaces at a distance inside or outside come from the same field, and so do the voxels
// inside.
#pragma once
#include "tools/bake/mesh.hpp"

namespace crn::bake
{

constexpr double solid_voxels_max =
    3e8; // voxels of the box around a mesh: a finer level set would take minutes

// The closed surface `offset_mm` outside the mesh (negative: inside), on a grid of `voxel_mm`; openings of
// the mesh are capped. Flat details thinner than about a voxel are lost. The result is empty when nothing
// lies that deep. Throws Fault when the grid would be too large.
Mesh offset_surface(const Mesh &mesh, double voxel_mm, double offset_mm);

// Expands the mesh by `close_mm` and shrinks it again: hollows and gaps up to twice as wide are filled, and
// the outside stays.
Mesh closed_surface(const Mesh &mesh, double voxel_mm, double close_mm);

// The part of `mesh` that lies in the box.
Mesh clipped(const Mesh &mesh, const Eigen::AlignedBox3d &box, double voxel_mm);

// The part of `mesh` that lies outside all of `taken`, each expanded by `gap_mm`.
Mesh difference(const Mesh &mesh, const std::vector<const Mesh *> &taken, double voxel_mm, double gap_mm);

// A voxel inside a closed mesh, and the distance of its middle, cell * voxel_mm, from the surface.
struct InsideVoxel {
    std::array<int, 3> cell;
    float depth_mm;
};
std::vector<InsideVoxel> inside_voxels(const Mesh &mesh, double voxel_mm);

// Splits vertices at which two sheets of a surface meet; afterwards every edge has two triangles.
void separate_sheets(Mesh &mesh);

} // namespace crn::bake
