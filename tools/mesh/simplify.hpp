/* Reduces the number of triangles of a closed surface, with a limit on the quadric error (the mean squared
 * distance from the original planes). */
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace crn::mesh
{

using Triangle = std::array<uint32_t, 3>; // counter-clockwise seen from outside

/* Collapses edges in the order of their cost, by the method of Garland and Heckbert (1997), until no collapse
 * costs less than error_mm. The cost of a collapse is the root mean square distance of the new vertex from
 * the planes of the triangles that the collapse replaces. The surface itself may move slightly farther than
 * error_mm, so a caller that guarantees a distance must measure this distance. The surface that is passed to
 * the function must be a closed manifold. Every collapse keeps the surface a closed manifold (link
 * condition), and turns no triangle by more than a right angle. The result is deterministic. */
void simplify(std::vector<Eigen::Vector3d> &vertices_mm, std::vector<Triangle> &triangles, double error_mm);

/* Collapses all edges shorter than length_mm, except those whose collapse would end the closed manifold. The
 * collapse of short edges also removes triangles whose corners almost coincide. The direction of a triangle
 * whose corners almost coincide depends on rounding errors, so the triangle seems to turn over when the
 * surface moves. A surface without edges shorter than length_mm is not changed. */
void drop_short_edges(std::vector<Eigen::Vector3d> &vertices_mm, std::vector<Triangle> &triangles,
                      double length_mm);

} // namespace crn::mesh
