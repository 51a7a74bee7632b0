/* Closed triangle meshes of solids: a level set (tools/mesh/level_set), its surface, and a simplification
 * that keeps the surface closed. */
#pragma once
#include "tools/anatomy/shapes.hpp"
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace anatomy
{

struct Mesh {
    std::vector<Vec3> vertices_mm;
    std::vector<std::array<uint32_t, 3>> triangles; // counter-clockwise seen from outside
};

/* Returns a distance function for points inside a box, correct where its value is below reach_mm. Only few
 * of a body's shapes matter near one place; finding them once per block makes meshing many times faster. */
using LocalDistance = std::function<Distance(const Box &box, double reach_mm)>;

/* The solid to mesh and the fineness. error_mm is how far simplification may move the surface (0: no
 * simplification). Edges shorter than shortest_mm are collapsed. */
struct MeshRequest {
    Box bounds;
    LocalDistance distance_in;
    double voxel_mm = 1.5;
    double error_mm = 0.15;
    double shortest_mm = 0;
};

/* The zero surface of the request; components with fewer than 60 triangles are dropped. Throws
 * std::runtime_error when the surface is empty or leaves the bounds. */
Mesh mesh_of(const MeshRequest &request);

/* Empty when each edge has exactly two triangles of opposite direction; otherwise the first fault in
 * words. */
std::string closed_mesh_fault(const Mesh &mesh);

double mesh_volume_mm3(const Mesh &mesh);

} // namespace anatomy
