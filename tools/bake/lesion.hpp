// Lesions: stretches of a vessel narrowed by plaque, in its tree and on its surface (docs/lesions.md).
//
//   place_lesions(tree, text.lesions)      // the branch's points become those of the narrowed channel
//   refine_lesions(mesh, tree)             // finer triangles where the wall will move
//   narrow_lesions(mesh.vertices_mm, tree) // the wall follows: one mesh for healthy and diseased vessel
//
// The channel narrows as a cosine (Young and Tsai, J Biomech 6 (1973) 395, eq. 1):
//   r = R (1 - S (1 + cos(2 pi u)) / 2)
// for u from -1/2 to 1/2 along the lesion, where S is the stenosis by diameter. The middle of the channel
// lies e (R - r) off the vessel's middle, away from the plaque.
#pragma once
#include "host/model/lesion_wall.hpp"
#include "tools/bake/container.hpp"
#include "tools/bake/field.hpp"
#include "tools/bake/mesh.hpp"
#include "tools/bake/triangle_tree.hpp"

namespace crn::bake
{

// Returns the box around everything within `radii` radii of a lesion's healthy centreline.
Eigen::AlignedBox3d lesion_box_mm(const VesselLesion &lesion, double radii);

// Throws Fault naming the lesion and what does not fit: the branch, the position, the length, or another
// lesion there.
void place_lesions(VesselTree &tree, const std::vector<LesionText> &lesions);

// Divides edges near a lesion until they are shorter than 0.6 radii at its narrowest point and than a
// twentieth of its length, but not below a quarter of a millimetre. Existing corners keep their numbers.
void refine_lesions(Mesh &mesh, const VesselTree &tree);

// Moves vertices from the healthy wall to the narrowed one; true marks a vertex that moved. The walls of
// other vessels stay.
std::vector<bool> narrow_lesions(std::vector<Eigen::Vector3d> &vertices_mm, const VesselTree &tree);

// The tree with only those lesions whose vessel runs through the body: blood beside a vessel is not narrowed
// with it.
VesselTree lesions_within(const VesselTree &tree, const TriangleTree &body);

// The regions where the field must resolve the narrow wall, whatever tolerance the scene states elsewhere.
// The tolerance is a fifteenth of the radius at the narrowest point (at least 0.03 mm), with voxels of at
// most 0.7 of it where the container has such voxels. Whatever passes the narrowest point of the mesh then
// also passes it in the field.
std::vector<FineRegion> fine_regions(const VesselTree &tree);

// A shell of calcium in the plaque of the lesion, over the arc that its text states. It exists only for
// lesions that state an arc.
BakedBody calcium_of(const VesselTree &tree, const VesselLesion &lesion, const LesionText &text);

// One line each for the report, with the diameter measured on the narrowed surface, and a warning where it
// differs from the tree's.
std::string lesions_report(const VesselTree &tree, const TriangleTree &surface);

} // namespace crn::bake
