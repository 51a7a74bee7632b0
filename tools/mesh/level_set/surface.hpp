// Turns the surface of a level set, which consists of quadrangles, into triangles, and separates sheets of
// the surface that touch each other.
#pragma once
#include "tools/mesh/simplify.hpp" // Triangle

namespace crn::mesh
{

struct QuadSurface {
    std::vector<Eigen::Vector3d> vertices;
    std::vector<std::array<uint32_t, 4>> quads; // counter-clockwise seen from outside
};

// Divides each quadrangle into two triangles along the diagonal from its second to its last vertex.
std::vector<Triangle> divided(const QuadSurface &surface);

// Divides each quadrangle into two triangles along its shorter diagonal. The shorter diagonal is better after
// the vertices were moved onto the true surface, because the quadrangles are then no longer nearly square.
std::vector<Triangle> divided_shorter(const QuadSurface &surface);

// Splits every vertex at which two sheets of a surface touch; afterwards every edge belongs to exactly two
// triangles.
void separate_sheets(std::vector<Eigen::Vector3d> &vertices, std::vector<Triangle> &triangles);

} // namespace crn::mesh
