// The part keeps all triangles in the blocks and in a margin around them. The library OpenVDB computes a
// distance from triangles at most 17 voxels away: 14 steps of its band, 2 voxels of its first voxels, and 1
// of its smoothing. The margin is wider, because signs are wrong in the pockets that a square may close
// between itself and the wall.
#include "tools/bake/field.hpp"

#include <algorithm>
#include <cmath>

namespace crn::bake
{
namespace
{

using mesh::Cell;
constexpr int margin_blocks = 4; // one beside those that the caller names, and 24 voxels
constexpr int face_squares = 2;  // along one edge of a block's face

// Returns all blocks that are at most `margin_blocks` away from one of the list, sorted.
std::vector<Cell> with_margin(std::vector<Cell> blocks)
{
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<Cell> wider;
        wider.reserve(blocks.size() * (2 * margin_blocks + 1));
        for (const Cell &cell : blocks)
            for (int by = -margin_blocks; by <= margin_blocks; ++by) {
                wider.push_back(cell);
                wider.back()[axis] += by;
            }
        std::sort(wider.begin(), wider.end());
        wider.erase(std::unique(wider.begin(), wider.end()), wider.end());
        blocks = std::move(wider);
    }
    return blocks;
}

Eigen::Vector3d corner_mm(const Cell &cell, double block_mm)
{
    return Eigen::Vector3d(cell[0], cell[1], cell[2]) * block_mm;
}

// Adds the squares of one face of a block that may lie inside the mesh. Squares outside it would do no
// harm, but each costs time. The face lies across `axis`, at the block's far side if `far` is true.
void close_face(Mesh &part, const TriangleTree &tree, const Cell &cell, int axis, bool far, double block_mm)
{
    const double edge_mm = block_mm / face_squares, half_diagonal_mm = edge_mm * std::sqrt(0.5);
    Eigen::Vector3d face = corner_mm(cell, block_mm);
    face[axis] += far ? block_mm : 0;
    const Eigen::Vector3d u = Eigen::Vector3d::Unit((axis + 1) % 3) * edge_mm,
                          v = Eigen::Vector3d::Unit((axis + 2) % 3) * edge_mm;
    for (int n = 0; n < face_squares * face_squares; ++n) {
        const Eigen::Vector3d at = face + n % face_squares * u + n / face_squares * v;
        if (tree.nearest(at + (u + v) / 2).distance_mm > 1.01 * half_diagonal_mm) continue;
        const auto first = static_cast<std::uint32_t>(part.vertices_mm.size());
        for (const Eigen::Vector3d &vertex :
             {at, Eigen::Vector3d(at + u), Eigen::Vector3d(at + u + v), Eigen::Vector3d(at + v)})
            part.vertices_mm.push_back(vertex);
        part.triangles.push_back({first, first + 1, first + 2});
        part.triangles.push_back({first, first + 2, first + 3});
    }
}

} // namespace

Mesh near_part(const TriangleTree &tree, std::vector<Cell> blocks, double block_mm)
{
    const std::vector<Cell> kept = with_margin(std::move(blocks));
    const Mesh &whole = tree.mesh();
    std::vector<bool> is_near(whole.triangles.size());
    std::vector<std::uint32_t> triangles;
    for (const Cell &cell : kept) {
        const Eigen::Vector3d low = corner_mm(cell, block_mm);
        tree.near({low, low + Eigen::Vector3d::Constant(block_mm)}, triangles);
        for (std::uint32_t t : triangles) is_near[t] = true;
    }
    // The triangles keep their order, by which OpenVDB chooses between two that are equally near.
    Mesh part{whole.name, whole.vertices_mm, {}, {}};
    for (std::size_t t = 0; t < whole.triangles.size(); ++t)
        if (is_near[t]) part.triangles.push_back(whole.triangles[t]);
    for (const Cell &cell : kept)
        for (int side = 0; side < 6; ++side) {
            Cell beside = cell;
            beside[side / 2] += side % 2 ? 1 : -1;
            if (!std::binary_search(kept.begin(), kept.end(), beside))
                close_face(part, tree, cell, side / 2, side % 2, block_mm);
        }
    return part;
}

} // namespace crn::bake
