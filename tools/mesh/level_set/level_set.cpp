// OpenVDB's grids. OpenVDB's function that converts a mesh to a level set is a template. The code uses
// OpenVDB's template with types for which the library is already compiled, because compiling the template for
// other types takes a minute.
#include "tools/mesh/level_set/level_set.hpp"
#include "tools/mesh/progress.hpp"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tools/VolumeToMesh.h>

#include <cmath>

namespace crn::mesh
{
namespace
{

struct Interrupter final : openvdb::util::NullInterrupter {
    bool wasInterrupted(int) override { return bake::Progress::interrupted(); }
};

using Tree = openvdb::FloatTree;

openvdb::Coord origin_of(const Cell &block)
{
    return {block_edge * block[0], block_edge * block[1], block_edge * block[2]};
}

openvdb::Coord voxel_of(const openvdb::Coord &origin, int number)
{
    return origin.offsetBy(number % block_edge, number / block_edge % block_edge,
                           number / block_edge / block_edge);
}

} // namespace

struct LevelSet::Grid {
    openvdb::FloatGrid::Ptr grid;
    double band;
};

LevelSet::LevelSet(double voxel, double band) : grid_(std::make_unique<Grid>())
{
    openvdb::initialize(); // may be called again
    grid_->band = band;
    grid_->grid = openvdb::FloatGrid::create(static_cast<float>(band));
    grid_->grid->setTransform(openvdb::math::Transform::createLinearTransform(voxel));
    grid_->grid->setGridClass(openvdb::GRID_LEVEL_SET);
}

LevelSet::LevelSet(const std::vector<Eigen::Vector3d> &vertices_mm, const std::vector<Triangle> &triangles,
                   double voxel_mm, double place, double outside, double inside)
    : grid_(std::make_unique<Grid>())
{
    openvdb::initialize();
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> corners;
    points.reserve(vertices_mm.size());
    corners.reserve(triangles.size());
    for (const Eigen::Vector3d &v : vertices_mm) {
        const Eigen::Vector3f at = (v.array() / voxel_mm - place).cast<float>();
        points.emplace_back(at.x(), at.y(), at.z());
    }
    for (const Triangle &t : triangles) corners.emplace_back(t[0], t[1], t[2]);
    Interrupter interrupter;
    grid_->band = outside * voxel_mm;
    grid_->grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(
        interrupter.interrupter(),
        openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I>(points, corners),
        *openvdb::math::Transform::createLinearTransform(voxel_mm), static_cast<float>(outside),
        static_cast<float>(inside));
}

LevelSet::LevelSet(LevelSet &&) noexcept = default;
LevelSet::~LevelSet() = default;

void LevelSet::set_near(const Cell &block, const Block &distances)
{
    auto access = grid_->grid->getAccessor();
    const openvdb::Coord origin = origin_of(block);
    for (int n = 0; n < static_cast<int>(distances.size()); ++n)
        if (std::abs(distances[n]) < grid_->band)
            access.setValue(voxel_of(origin, n), static_cast<float>(distances[n]));
}

void LevelSet::set(const Cell &block, const Block &distances)
{
    const openvdb::Coord origin = origin_of(block);
    auto *leaf = grid_->grid->tree().touchLeaf(origin);
    for (int n = 0; n < static_cast<int>(distances.size()); ++n)
        leaf->setValueOn(voxel_of(origin, n), static_cast<float>(distances[n]));
}

void LevelSet::fill_signs()
{
    openvdb::tools::signedFloodFill(grid_->grid->tree());
}

// Voxels without a distance keep their value: it states only on which side of the surface they lie.
void LevelSet::expand(double distance)
{
    const auto by = static_cast<float>(distance);
    for (auto leaf = grid_->grid->tree().beginLeaf(); leaf; ++leaf)
        for (auto value = leaf->beginValueOn(); value; ++value) value.setValue(*value - by);
}

void LevelSet::intersect(LevelSet &&other)
{
    openvdb::tools::csgIntersection(*grid_->grid, *other.grid_->grid);
}

void LevelSet::subtract(LevelSet &&other)
{
    openvdb::tools::csgDifference(*grid_->grid, *other.grid_->grid);
}

std::vector<Cell> LevelSet::blocks() const
{
    std::vector<Cell> blocks;
    for (auto leaf = grid_->grid->tree().cbeginLeaf(); leaf; ++leaf) {
        const openvdb::Coord at = leaf->origin();
        blocks.push_back({at.x() >> 3, at.y() >> 3, at.z() >> 3});
    }
    return blocks;
}

void LevelSet::change(const Cell &block, const std::function<float(const Cell &, float)> &change)
{
    Tree::LeafNodeType *leaf = grid_->grid->tree().probeLeaf(origin_of(block));
    for (auto value = leaf->beginValueOn(); value; ++value) {
        const openvdb::Coord at = value.getCoord();
        value.setValue(change({at.x(), at.y(), at.z()}, *value));
    }
}

std::vector<double> LevelSet::read(const Cell &low, int edge, double unit) const
{
    auto in = grid_->grid->getConstAccessor();
    std::vector<double> values;
    values.reserve(static_cast<std::size_t>(edge) * edge * edge);
    for (int z = 0; z < edge; ++z)
        for (int y = 0; y < edge; ++y)
            for (int x = 0; x < edge; ++x)
                values.push_back(in.getValue({low[0] + x, low[1] + y, low[2] + z}) / unit);
    return values;
}

std::vector<InsideVoxel> LevelSet::inside() const
{
    std::vector<InsideVoxel> inside;
    for (auto value = grid_->grid->cbeginValueOn(); value; ++value) {
        const openvdb::Coord at = value.getCoord();
        if (*value < 0) inside.push_back({{at.x(), at.y(), at.z()}, -*value});
    }
    return inside;
}

QuadSurface LevelSet::surface(double at) const
{
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec4I> quads;
    openvdb::tools::volumeToMesh(*grid_->grid, points, quads, at);
    QuadSurface surface;
    surface.vertices.reserve(points.size());
    surface.quads.reserve(quads.size());
    for (const openvdb::Vec3s &p : points) surface.vertices.emplace_back(p.x(), p.y(), p.z());
    // OpenVDB returns the faces of a level set clockwise as seen from outside.
    for (const openvdb::Vec4I &q : quads) surface.quads.push_back({q[3], q[2], q[1], q[0]});
    return surface;
}

} // namespace crn::mesh
