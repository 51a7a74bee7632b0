/* Fewer triangles for a closed surface, by quadric error. */
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace crn::mesh
{

using Triangle = std::array<uint32_t, 3>; // counter-clockwise seen from outside

/* Edge collapse by quadric error (Garland and Heckbert 1997) until no collapse costs less than error_mm, the
 * root mean square distance from the planes it replaces: the surface itself may move a little further, so
 * whoever promises a distance must measure it. Every collapse keeps the surface a closed manifold (link
 * condition), which it must be at the beginning, and turns no triangle by more than a right angle.
 * Deterministic. */
void simplify(std::vector<Eigen::Vector3d> &vertices_mm, std::vector<Triangle> &triangles, double error_mm);

} // namespace crn::mesh
