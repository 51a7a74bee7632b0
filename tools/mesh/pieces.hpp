// Connected pieces of a surface.
#pragma once
#include "tools/mesh/simplify.hpp" // Triangle

namespace crn::mesh
{

// Returns, for each vertex, the number of the vertex that represents its connected piece; all vertices of a
// connected piece have the same representative.
std::vector<uint32_t> pieces_of(size_t vertex_count, const std::vector<Triangle> &triangles);

// Removes every connected piece with fewer than `least` triangles, or with less than the fraction `share` of
// the largest piece's triangles.
void drop_small_pieces(std::vector<Eigen::Vector3d> &vertices, std::vector<Triangle> &triangles, size_t least,
                       double share);

// Drops vertices without a triangle. The remaining vertices are numbered in the order in which the triangles
// use them.
void drop_unused(std::vector<Eigen::Vector3d> &vertices, std::vector<Triangle> &triangles);

} // namespace crn::mesh
