// Remakes a body's surface from a level set. Overlapping pieces become one solid, and cracks and faults of
// the mesh vanish. The same distance field also gives surfaces at a distance inside or outside, and the
// voxels inside the body.
#pragma once
#include "tools/bake/mesh.hpp"
#include "tools/mesh/level_set/level_set.hpp"

namespace crn::bake
{

constexpr double solid_voxels_max =
    3e8; // voxels of the box around a mesh: a finer level set would take minutes

// Returns the closed surface that lies `offset_mm` outside the mesh (negative: inside), made on a grid of
// `voxel_mm`. Openings of the mesh are capped. Flat details thinner than about a voxel are lost. The result
// is empty when no place of the body is as deep as `offset_mm`. Throws Fault when the grid would need too
// many voxels.
Mesh offset_surface(const Mesh &mesh, double voxel_mm, double offset_mm);

// Expands the mesh by `close_mm` and shrinks it again. This closing fills hollows and gaps up to twice
// `close_mm` wide and leaves the rest of the outside unchanged.
Mesh closed_surface(const Mesh &mesh, double voxel_mm, double close_mm);

// Returns the part of `mesh` that lies in the box.
Mesh clipped(const Mesh &mesh, const Eigen::AlignedBox3d &box, double voxel_mm);

// Returns the part of `mesh` that lies outside all meshes of `taken`, each of which is first expanded by
// `gap_mm`.
Mesh difference(const Mesh &mesh, const std::vector<const Mesh *> &taken, double voxel_mm, double gap_mm);

// Returns the voxels inside a closed mesh with their depth below its surface.
std::vector<mesh::InsideVoxel> inside_voxels(const Mesh &mesh, double voxel_mm);

// Returns signed distances to a closed mesh (LevelSet has the same constructor).
mesh::LevelSet level_set(const Mesh &mesh, double voxel_mm, double place, double outside, double inside);

} // namespace crn::bake
