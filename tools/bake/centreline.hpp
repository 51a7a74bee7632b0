// Centrelines with radii (files of tools/centreline) in the patient, and the surface of the vessel they
// describe.
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

// Reads every curve of a .mrk.json, .vtp, .csv or .obj file; `read_centreline` gives the first. What a file
// says of its axes is ignored: `placement.axes` says what they are. A branch of many is called FILE/BRANCH.
// Throws Fault naming file, point and field.
std::vector<Centreline> read_centrelines(const std::filesystem::path &file, const Placement &placement);
Centreline read_centreline(const std::filesystem::path &file, const Placement &placement);

// Position and unit tangent at a distance along the curve from its first or last point, looking into the
// curve.
struct CurvePoint {
    Eigen::Vector3d position_mm, direction;
};
CurvePoint along(const Centreline &line, bool from_last, double distance_mm);

// The union of the tapered capsules between neighbouring points, as a closed mesh made at the given voxel.
Mesh surface_of(const std::vector<Centreline> &lines, double voxel_mm, Progress &progress);

} // namespace crn::bake
