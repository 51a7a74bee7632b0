/* Reduces the number of triangles of a closed surface with a limited quadric error. */
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace crn::mesh
{

using Triangle = std::array<uint32_t, 3>; // counter-clockwise seen from outside

/* Collapses edges by quadric error (Garland and Heckbert 1997) until no collapse costs less than error_mm.
 * The cost is the root mean square distance from the planes that the collapse replaces. The surface itself
 * may move slightly farther, so a caller that promises a distance must measure it. The surface must be a
 * closed manifold. Every collapse keeps the surface a closed manifold (link condition), and turns no triangle
 * by more than a right angle. The result is deterministic. */
void simplify(std::vector<Eigen::Vector3d> &vertices_mm, std::vector<Triangle> &triangles, double error_mm);

/* Collapses all edges shorter than length_mm whose collapse keeps the closed manifold one. Triangles whose
 * corners almost coincide thereby vanish: their direction is that of rounding errors, so they seem to turn
 * over when the surface moves. A surface without such edges is not changed. */
void drop_short_edges(std::vector<Eigen::Vector3d> &vertices_mm, std::vector<Triangle> &triangles,
                      double length_mm);

} // namespace crn::mesh
