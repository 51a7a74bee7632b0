// Centrelines with radii (3D Slicer markups curves) and the surface of the vessel they describe.
// May include: mesh.hpp. Called by: bake.cpp, tests.
#pragma once
#include "tools/bake/mesh.hpp"

namespace seld::bake
{

constexpr std::size_t centreline_points_max = 100'000;

struct Centreline {
    std::string name;
    std::vector<Eigen::Vector3d> points_mm; // patient frame
    std::vector<double> radii_mm;
};

// Reads the first curve of a .mrk.json file. Its coordinateSystem is ignored: `placement.axes` says what the axes are.
// Throws Fault naming file, control point and field.
Centreline read_centreline(const std::filesystem::path &file, const Placement &placement);

// Position and unit tangent at a distance along the curve from its first or last point, looking into the curve.
struct CurvePoint {
    Eigen::Vector3d position_mm, direction;
};
CurvePoint along(const Centreline &line, bool from_last, double distance_mm);

// Distance to a capsule whose radius changes linearly from a to b (the hull of the two spheres), negative inside.
double tapered_capsule_distance(const Eigen::Vector3d &p, const Eigen::Vector3d &a, double radius_a,
                                const Eigen::Vector3d &b, double radius_b);

// The union of the tapered capsules between neighbouring points, as a closed mesh made at the given voxel.
Mesh surface_of(const std::vector<Centreline> &lines, double voxel_mm, Progress &progress);

} // namespace seld::bake
