// These functions place centrelines with radii, read by tools/centreline, in the patient and build the vessel
// surface that they describe.
#pragma once
#include "tools/bake/mesh.hpp"
#include "tools/centreline/tree.hpp"

namespace crn::bake
{

using centreline::tapered_capsule_distance;

struct Centreline {
    std::string name;
    std::vector<Eigen::Vector3d> points_mm; // patient frame
    std::vector<double> radii_mm;
};

// Reads every curve of a .mrk.json, .vtp, .csv or .obj file; `read_centreline` returns the first. The axes
// that the file itself states are ignored: `placement.axes` decides. A branch of a file with several branches
// is called FILE/BRANCH. Throws Fault naming file, point and field.
std::vector<Centreline> read_centrelines(const std::filesystem::path &file, const Placement &placement);
Centreline read_centreline(const std::filesystem::path &file, const Placement &placement);

// Returns the position and unit tangent at a distance along the curve from its first or last point. The
// tangent points from the end into the curve.
struct CurvePoint {
    Eigen::Vector3d position_mm, direction;
};
CurvePoint along(const Centreline &line, bool from_last, double distance_mm);

// Returns the union of the tapered capsules between neighbouring points, as a closed mesh made on a grid of
// the given voxel size.
Mesh surface_of(const std::vector<Centreline> &lines, double voxel_mm, Progress &progress);

} // namespace crn::bake
