// Remakes a body's surface from a level set. Remaking a surface joins overlapping pieces into one solid, and
// removes cracks and other faults of the mesh. The distance field of a body also gives the surfaces at a
// given distance outside or inside the body, and the voxels inside it.
#pragma once
#include "tools/bake/mesh.hpp"
#include "tools/mesh/level_set/level_set.hpp"

namespace crn::bake
{

constexpr double solid_voxels_max =
    3e8; // voxels of the box around a mesh: a finer level set would take minutes

// Returns the closed surface at the distance `offset_mm` outside the mesh (inside, if `offset_mm` is
// negative); the surface is made on a grid of `voxel_mm`. Openings of the mesh are capped. Flat details of
// the surface that are thinner than about one voxel are lost. The result is empty when a negative `offset_mm`
// is larger than the greatest depth inside the body. Throws Fault when the grid would need too many voxels.
Mesh offset_surface(const Mesh &mesh, double voxel_mm, double offset_mm);

// Expands the mesh by `close_mm` and shrinks it again by `close_mm`. Expanding and shrinking fills hollows
// and gaps up to twice `close_mm` wide, and leaves the rest of the outer surface unchanged.
Mesh closed_surface(const Mesh &mesh, double voxel_mm, double close_mm);

// Returns the part of `mesh` that lies in the box.
Mesh clipped(const Mesh &mesh, const Eigen::AlignedBox3d &box, double voxel_mm);

// Returns the part of `mesh` that lies outside every mesh of the list `taken`, after each mesh of that list
// has been expanded by `gap_mm`.
Mesh difference(const Mesh &mesh, const std::vector<const Mesh *> &taken, double voxel_mm, double gap_mm);

// Returns the voxels inside a closed mesh, each with its depth below the mesh's surface.
std::vector<mesh::InsideVoxel> inside_voxels(const Mesh &mesh, double voxel_mm);

// Returns the level set of signed distances to a closed mesh (the constructor of LevelSet explains the
// parameters).
mesh::LevelSet level_set(const Mesh &mesh, double voxel_mm, double place, double outside, double inside);

} // namespace crn::bake
