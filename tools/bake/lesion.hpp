// A lesion is a stretch of a vessel that is narrowed by plaque, both in the vessel's tree and on its surface
// (docs/lesions.md).
//
//   place_lesions(tree, text.lesions)      // the branch's points become those of the narrowed channel
//   refine_lesions(mesh, tree)             // finer triangles where the wall will move
//   narrow_lesions(mesh.vertices_mm, tree) // the wall follows: one mesh for healthy and diseased vessel
//
// The channel narrows as a cosine (Young and Tsai, J Biomech 6 (1973) 395, eq. 1):
//   r = R (1 - S (1 + cos(2 pi u)) / 2)
//
// The formula for the narrowed radius uses u from -1/2 to 1/2 along the lesion, the radius R of the healthy
// vessel, and the stenosis S by diameter. With eccentricity e, the centre of the narrowed channel (radius r)
// lies e (R - r) from the vessel's centre, away from the plaque.
#pragma once
#include "host/model/lesion_wall.hpp"
#include "tools/bake/container.hpp"
#include "tools/bake/field.hpp"
#include "tools/bake/mesh.hpp"
#include "tools/bake/triangle_tree.hpp"

namespace crn::bake
{

// Returns the box that contains every point within `radii` vessel radii of a lesion's healthy centreline.
Eigen::AlignedBox3d lesion_box_mm(const VesselLesion &lesion, double radii);

// Throws Fault when a lesion does not suit its vessel; the message names the lesion and the fault, such as
// its branch, position or length, or another lesion in the same place.
void place_lesions(VesselTree &tree, const std::vector<LesionText> &lesions);

// Divides the mesh's edges near a lesion until they are shorter than 0.6 times the narrowest radius, and also
// shorter than a twentieth of the lesion's length. Edges shorter than a quarter of a millimetre are not
// divided. Existing corners keep their numbers.
void refine_lesions(Mesh &mesh, const VesselTree &tree);

// Moves vertices from the healthy wall to the narrowed wall; the returned list is true for each vertex that
// moved. Vertices on the walls of neighbouring vessels do not move.
std::vector<bool> narrow_lesions(std::vector<Eigen::Vector3d> &vertices_mm, const VesselTree &tree);

// Returns a copy of the vessel tree that keeps only those lesions whose vessel runs through the given body.
// Lesions of vessels outside the body (such as a chamber of the heart) thus do not narrow the blood in the
// body.
VesselTree lesions_within(const VesselTree &tree, const TriangleTree &body);

// Returns the regions in which the field must resolve the narrowed wall, even where the scene's text permits
// a larger tolerance. Near the narrowed wall the distance may be wrong by a fifteenth of the narrowest
// radius, or by 0.03 mm if this is larger. The edge of a voxel is at most 0.7 times the narrowest radius, if
// the scene container permits such small voxels. With the chosen resolution, a guidewire or catheter that
// passes the narrowest point of the mesh also passes that of the field.
std::vector<FineRegion> fine_regions(const VesselTree &tree);

// Returns a shell of calcium in the plaque of the lesion, over the arc that the lesion's text states. Only
// lesions whose text states an arc have a shell of calcium.
BakedBody calcium_of(const VesselTree &tree, const VesselLesion &lesion, const LesionText &text);

// Returns one report line per lesion, with the diameter measured on the narrowed surface. A report line has a
// warning if the vessel tree has another diameter there.
std::string lesions_report(const VesselTree &tree, const TriangleTree &surface);

} // namespace crn::bake
