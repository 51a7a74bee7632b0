// Connected pieces of a surface.
#pragma once
#include "tools/mesh/simplify.hpp" // Triangle

namespace crn::mesh
{

// Returns for each vertex the number of one vertex that stands for its connected piece.
std::vector<uint32_t> pieces_of(size_t vertex_count, const std::vector<Triangle> &triangles);

// Drops connected pieces that have fewer triangles than `least`, or than `share` of the largest piece.
void drop_small_pieces(std::vector<Eigen::Vector3d> &vertices, std::vector<Triangle> &triangles, size_t least,
                       double share);

// Drops vertices without a triangle. The others are numbered in the order in which the triangles use them.
void drop_unused(std::vector<Eigen::Vector3d> &vertices, std::vector<Triangle> &triangles);

} // namespace crn::mesh
