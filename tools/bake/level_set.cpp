// This file holds the only call of OpenVDB's converter. It uses the types that OpenVDB's library has
// precompiled, because our own types would take a minute to compile.
#include "tools/bake/level_set.hpp"
#include "tools/mesh/progress.hpp"

#include <openvdb/tools/MeshToVolume.h>

namespace crn::bake
{
namespace
{

struct Interrupter final : openvdb::util::NullInterrupter {
    bool wasInterrupted(int) override { return Progress::interrupted(); }
};

} // namespace

openvdb::FloatGrid::Ptr level_set(const Mesh &mesh, double voxel_mm, double place, double outside,
                                  double inside)
{
    start_openvdb();
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    points.reserve(mesh.vertices_mm.size());
    triangles.reserve(mesh.triangles.size());
    for (const Eigen::Vector3d &v : mesh.vertices_mm) {
        const Eigen::Vector3f at = (v.array() / voxel_mm - place).cast<float>();
        points.emplace_back(at.x(), at.y(), at.z());
    }
    for (const Triangle &t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
    Interrupter interrupter;
    return openvdb::tools::meshToVolume<openvdb::FloatGrid>(
        interrupter.interrupter(),
        openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I>(points, triangles),
        *openvdb::math::Transform::createLinearTransform(voxel_mm), static_cast<float>(outside),
        static_cast<float>(inside));
}

} // namespace crn::bake
