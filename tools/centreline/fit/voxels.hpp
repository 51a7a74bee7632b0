// Represents the inside of a closed mesh as voxels with their distance to the wall, and finds paths through
// these voxels that stay in the vessel's middle.
#pragma once
#include "tools/bake/mesh.hpp"

namespace crn::centreline
{

constexpr double voxels_inside_max = 3e7;

class Voxels
{
  public:
    // Throws a Fault when the mesh encloses no volume, or needs too many voxels.
    Voxels(const bake::Mesh &closed, double voxel_mm);

    std::size_t size() const { return depth_mm_.size(); }
    double voxel_mm() const { return voxel_mm_; }
    Eigen::Vector3d centre_mm(std::size_t voxel) const;
    double depth_mm(std::size_t voxel) const { return depth_mm_[voxel]; } // distance to the wall, above 0
    // Returns the inside voxel nearest to the point, or -1 if no inside voxel lies within `reach_mm` of the
    // point.
    long nearest(const Eigen::Vector3d &p_mm, double reach_mm) const;
    // Moves from the given voxel in the direction of steepest increase of depth (distance to the wall), and
    // returns the last voxel, which lies in the middle of the vessel. The path of steepest increase of the
    // depth never runs along the vessel.
    std::size_t middle_near(std::size_t voxel) const;
    // Calls use(neighbour, distance_mm) for those of a voxel's 26 neighbours that a straight path certainly
    // reaches inside the vessel. If the largest balls inside the vessel around two voxel centres overlap,
    // they contain the segment between the centres, so this segment crosses no thin wall.
    template <typename Use> void each_neighbour(std::size_t voxel, Use use) const
    {
        const Eigen::Array3i local = cell_[voxel] - low_;
        for (int z = -1; z <= 1; ++z)
            for (int y = -1; y <= 1; ++y)
                for (int x = -1; x <= 1; ++x) {
                    if (x == 0 && y == 0 && z == 0) continue;
                    const long other = at(local[0] + x, local[1] + y, local[2] + z);
                    if (other < 0) continue;
                    const double distance = step_mm_[x * x + y * y + z * z];
                    if (depth_mm_[voxel] + depth_mm_[other] >= distance)
                        use(static_cast<std::size_t>(other), distance);
                }
    }

  private:
    // The voxel's number, or -1 outside. The position counts from `low_`. Searches call this 26 times per
    // voxel.
    long at(int x, int y, int z) const
    {
        if (x < 0 || y < 0 || z < 0) return -1;
        const Eigen::Array3i b(x >> 3, y >> 3, z >> 3);
        if (b[0] >= bricks_[0] || b[1] >= bricks_[1] || b[2] >= bricks_[2]) return -1;
        const std::int32_t brick = brick_of_[brick_index(b)];
        return brick < 0 ? -1 : brick_[brick][(x & 7) + 8 * ((y & 7) + 8 * (z & 7))];
    }
    std::size_t brick_index(const Eigen::Array3i &b) const
    {
        return b[0] +
               static_cast<std::size_t>(bricks_[0]) * (b[1] + static_cast<std::size_t>(bricks_[1]) * b[2]);
    }

    double voxel_mm_;
    std::array<double, 4> step_mm_; // to a neighbour along one, two or three axes
    Eigen::Array3i low_, bricks_;
    std::vector<std::int32_t> brick_of_; // coarse grid -> brick, -1: nothing inside
    std::vector<std::array<std::int32_t, 512>> brick_;
    std::vector<Eigen::Array3i> cell_;
    std::vector<float> depth_mm_;
};

// Holds the cheapest paths from the source voxels to every voxel. A millimetre of path costs 1 / depth^2,
// where depth is the distance to the vessel wall, so the cheapest paths run in the middle of the vessel.
struct Ways {
    std::vector<std::int32_t> from;   // -1: not reached; a source points to itself
    std::vector<float> length_mm;     // from the source
    std::vector<std::int32_t> source; // index in the list of sources

    // Returns the cheapest path from a source voxel to the given voxel.
    std::vector<std::size_t> to(std::size_t voxel) const;
};
// Finds the cheapest paths from the source voxels; if `target` is not -1, the search ends when it reaches
// this voxel. Throws Fault when the user has interrupted the program.
Ways find_ways(const Voxels &voxels, const std::vector<std::size_t> &sources, long target);

} // namespace crn::centreline
