// Signed distances on a grid: made from a mesh or from blocks of numbers, combined, read, and turned into a
// surface. Every tool that meshes a solid uses this room, which is the only one that knows OpenVDB.
#pragma once
#include "tools/mesh/level_set/surface.hpp"

#include <functional>
#include <memory>

namespace crn::mesh
{

constexpr int block_edge = 8; // voxels along one side of a block

using Cell = std::array<int, 3>; // a voxel or a block, counted from the origin along x, y and z

// The distances of one block. Voxel (x, y, z) of it has the number x + 8 y + 64 z.
using Block = std::array<double, block_edge * block_edge * block_edge>;

// A voxel inside a closed surface, and the distance of its middle, cell * voxel, from the surface.
struct InsideVoxel {
    Cell cell;
    float depth_mm;
};

// Distances are negative inside. A voxel's middle lies at its cell times the voxel's edge. Points of surfaces
// are rounded to float.
class LevelSet
{
  public:
    // An empty grid: everything is outside, `band` away from a surface. Blocks follow, then fill_signs().
    // Surfaces are in the unit of `voxel`, which differs from that of the distances when a caller wants it.
    LevelSet(double voxel, double band);

    // Distances to a closed mesh, kept up to `outside` and `inside` voxels from its surface. The middle of
    // voxel (i, j, k) stands for the point (i + place, j + place, k + place) * voxel_mm of the mesh. Points
    // are rounded to float in voxels: 1e-4 voxels at 1,000 voxels from the origin. Ctrl-C ends the work early
    // with what is there.
    LevelSet(const std::vector<Eigen::Vector3d> &vertices_mm, const std::vector<Triangle> &triangles,
             double voxel_mm, double place, double outside, double inside);

    LevelSet(LevelSet &&) noexcept;
    ~LevelSet();

    // Sets the distances of a block that are nearer than the band. The others keep their value.
    void set_near(const Cell &block, const Block &distances);
    // Sets all distances of a block.
    void set(const Cell &block, const Block &distances);
    // Gives the sign of the surface around them to all voxels that have no distance. The surface must lie in
    // blocks that were set.
    void fill_signs();

    void intersect(LevelSet &&other); // keeps what lies inside of both
    void subtract(LevelSet &&other);  // keeps what lies outside of the other

    std::vector<Cell> blocks() const; // those that have distances
    // Replaces the distances of a block by what `change` returns for their voxel and their old value.
    // Different blocks may be changed at the same time.
    void change(const Cell &block, const std::function<float(const Cell &, float)> &change);
    // Reads a cube of edge^3 voxels, x fastest, and divides each distance by `unit`.
    std::vector<double> read(const Cell &low, int edge, double unit) const;

    std::vector<InsideVoxel> inside() const;

    // The surface where the distance is `at`: one vertex per voxel that it crosses.
    QuadSurface surface(double at = 0) const;

  private:
    struct Grid;
    std::unique_ptr<Grid> grid_;
};

} // namespace crn::mesh
