// Lesions: a stretch of a vessel narrowed by plaque, in its tree and on its surface (docs/lesions.md).
//
//   place_lesions(tree, text.lesions)      // the branch's points become those of the channel that is left
//   refine_lesions(mesh, tree)             // finer triangles where the wall will move
//   narrow_lesions(mesh.vertices_mm, tree) // the wall goes with it: one mesh for the healthy and the
//   diseased vessel
//
// The channel narrows as a cosine (Young and Tsai, J Biomech 6 (1973) 395, eq. 1): r = R (1 - S (1 + cos(2 pi
// u)) / 2) for u from -1/2 to 1/2 along the lesion, S the stenosis by diameter. Its middle lies e (R - r) off
// the vessel's, away from the plaque.
#pragma once
#include "host/model/lesion_wall.hpp"
#include "tools/bake/container.hpp"
#include "tools/bake/field.hpp"
#include "tools/bake/mesh.hpp"
#include "tools/bake/triangle_tree.hpp"

namespace crn::bake
{

// Box around everything within so many radii of a lesion's healthy centreline.
Eigen::AlignedBox3d lesion_box_mm(const VesselLesion &lesion, double radii);

// Throws Fault naming the lesion and what does not fit: branch, place, length, another lesion there.
void place_lesions(VesselTree &tree, const std::vector<LesionText> &lesions);

// Edges near a lesion are divided until they are shorter than 0.6 radii of its throat and a twentieth of its
// length, or than a quarter of a millimetre. Corners that were there keep their numbers.
void refine_lesions(Mesh &mesh, const VesselTree &tree);

// From the healthy vessel to the narrowed one; true: that vertex moved. The walls of other vessels stay.
std::vector<bool> narrow_lesions(std::vector<Eigen::Vector3d> &vertices_mm, const VesselTree &tree);

// The tree with those lesions only whose vessel runs through a body: blood beside a vessel is not narrowed
// with it.
VesselTree lesions_within(const VesselTree &tree, const TriangleTree &body);

// Where the field must know the narrow wall, whatever the scene asks elsewhere: within a fifteenth of the
// throat's radius (0.03 mm at least), in voxels of 0.7 of it at most where the container has such, so that
// what passes the throat in the mesh passes it in the field.
std::vector<FineRegion> fine_regions(const VesselTree &tree);

// A shell of calcium in the plaque of the lesion, over the arc that its text states; for lesions that state
// one.
BakedBody calcium_of(const VesselTree &tree, const VesselLesion &lesion, const LesionText &text);

// One line each for the report, with the diameter measured on the narrowed surface, and a warning where that
// is not the tree's.
std::string lesions_report(const VesselTree &tree, const TriangleTree &surface);

} // namespace crn::bake
