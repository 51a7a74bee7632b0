// Surfaces of level sets as triangles: quadrangles are divided, and sheets that touch are separated.
#pragma once
#include "tools/mesh/simplify.hpp" // Triangle

namespace crn::mesh
{

struct QuadSurface {
    std::vector<Eigen::Vector3d> vertices;
    std::vector<std::array<uint32_t, 4>> quads; // counter-clockwise seen from outside
};

// Divides each quadrangle along the diagonal from its second to its last vertex.
std::vector<Triangle> divided(const QuadSurface &surface);

// Divides each quadrangle along its shorter diagonal. It suits vertices that were moved onto the true
// surface, because those quadrangles are no longer nearly square.
std::vector<Triangle> divided_shorter(const QuadSurface &surface);

// Splits vertices at which two sheets of a surface meet; afterwards every edge has two triangles.
void separate_sheets(std::vector<Eigen::Vector3d> &vertices, std::vector<Triangle> &triangles);

} // namespace crn::mesh
