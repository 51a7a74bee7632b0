// Stores signed distances on a grid (a level set). The distances come from a mesh or from blocks of numbers;
// the class can combine two grids, return distances, and make a surface. Every tool that meshes a solid uses
// this room, which is the only one that knows OpenVDB.
#pragma once
#include "tools/mesh/level_set/surface.hpp"

#include <functional>
#include <memory>

namespace crn::mesh
{

constexpr int block_edge = 8; // voxels along one side of a block

using Cell = std::array<int, 3>; // a voxel or a block, counted from the origin along x, y and z

// The distances of one block. Voxel (x, y, z) of the block has the number x + 8 y + 64 z.
using Block = std::array<double, block_edge * block_edge * block_edge>;

// Holds a voxel inside a closed surface, and the distance from the surface to the middle of this voxel. The
// middle of the voxel lies at `cell` times the edge length of a voxel.
struct InsideVoxel {
    Cell cell;
    float depth_mm;
};

// Distances are negative inside. The middle of a voxel lies at its cell number times the edge length of a
// voxel. The vertices of returned surfaces are rounded to 32-bit floating point.
class LevelSet
{
  public:
    // Makes an empty grid with the stored distance `band`, in which every voxel counts as outside. Blocks
    // follow, then fill_signs(). The vertices of surfaces are in the unit of `voxel`; a caller may use a
    // different unit for the distances.
    LevelSet(double voxel, double band);

    // Makes a grid of distances to a closed mesh, from `inside` voxels inside the mesh's surface to `outside`
    // voxels outside it. Voxel (i, j, k) stores the distance at the point (i + place, j + place, k + place) *
    // voxel_mm in the mesh's coordinates. Coordinates are rounded to 32-bit floating point; at 1,000 voxels
    // from the origin, this error is 1e-4 voxels. After Ctrl-C the constructor ends early, and the grid is
    // incomplete.
    LevelSet(const std::vector<Eigen::Vector3d> &vertices_mm, const std::vector<Triangle> &triangles,
             double voxel_mm, double place, double outside, double inside);

    LevelSet(LevelSet &&) noexcept;
    ~LevelSet();

    // Stores only the distances of a block with a magnitude below the constructor's argument `band`. The
    // others keep their value.
    void set_near(const Cell &block, const Block &distances);
    // Stores all distances of a block.
    void set(const Cell &block, const Block &distances);
    // Gives every voxel without a stored distance a sign, inside or outside, according to the surface around
    // the voxel. The whole surface must lie in blocks whose distances were stored.
    void fill_signs();

    // Moves the surface outwards by `distance`, which must be smaller than the constructor's `outside`.
    void expand(double distance);
    void intersect(LevelSet &&other); // keeps what lies inside of both
    void subtract(LevelSet &&other);  // keeps what lies outside of the other

    std::vector<Cell> blocks() const; // those that have distances
    // Replaces each distance of a block by the value that `change` returns for the voxel and its old
    // distance. Several threads may change different blocks at the same time.
    void change(const Cell &block, const std::function<float(const Cell &, float)> &change);
    // Returns the distances of a cube of edge^3 voxels, divided by `unit`; x changes fastest.
    std::vector<double> read(const Cell &low, int edge, double unit) const;

    std::vector<InsideVoxel> inside() const;

    // Returns the surface of distance `at`, with one vertex in each voxel that the surface crosses.
    QuadSurface surface(double at = 0) const;

  private:
    struct Grid;
    std::unique_ptr<Grid> grid_;
};

} // namespace crn::mesh
