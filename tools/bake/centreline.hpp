// Converts centrelines with radii, read by tools/centreline, to the patient's coordinates, and builds the
// surface of the vessel around the centrelines.
#pragma once
#include "tools/bake/mesh.hpp"
#include "tools/centreline/tree.hpp"

namespace crn::bake
{

using centreline::tapered_capsule_distance;
using Curve = centreline::Branch; // its parent is not set: join_branches finds it

// Reads every curve of a .mrk.json, .vtp, .csv or .obj file; the function `read_centreline` returns only the
// first curve. The axis convention that the file itself states is ignored, because `placement.axes` states
// the axes. If a file has several branches, each branch is called `FILE/BRANCH`. Throws Fault, whose message
// names the file, the point and the field.
std::vector<Curve> read_centrelines(const std::filesystem::path &file, const Placement &placement);
Curve read_centreline(const std::filesystem::path &file, const Placement &placement);

// Returns the position and unit tangent at a given distance along the curve, counted from the curve's first
// or last point. At either end, the tangent points into the curve.
struct CurvePoint {
    Eigen::Vector3d position_mm, direction;
};
CurvePoint along(const Curve &line, bool from_last, double distance_mm);

// Returns a closed mesh of the union of tapered capsules, each of which joins two neighbouring points. The
// mesh is made on a grid of the given voxel size.
Mesh surface_of(const std::vector<Curve> &lines, double voxel_mm, Progress &progress);

// The flat triangles of such a surface lie inside the round vessel, by about the square of the voxel over the
// radius. Returns a warning with place, error and the voxel that would hold the radius, if a sphere of the
// curves lacks more than 2 % of its radius; otherwise an empty text. `surface` has passed check_closed.
std::string narrowing_warning(const Mesh &surface, const std::vector<Curve> &lines, double voxel_mm);

} // namespace crn::bake
