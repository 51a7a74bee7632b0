/* Makes closed triangle meshes of solids. A solid becomes a level set (tools/mesh/level_set), and the surface
 * of the level set is simplified and stays closed. */
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

/* Returns a distance function for points inside a box. Its value is correct where it is below reach_mm.
 * Only few shapes of a body matter near one place. They are found once per block, which makes meshing many
 * times faster. */
using LocalDistance = std::function<Distance(const Box &box, double reach_mm)>;
LocalDistance local_distance(const Solid &solid);

/* A solid, and how fine its mesh is. Simplification may move the surface by error_mm; 0 means no
 * simplification. Edges shorter than shortest_mm are collapsed. */
struct MeshRequest {
    Box bounds;
    LocalDistance distance_in;
    double voxel_mm = 1.5;
    double error_mm = 0.15;
    double shortest_mm = 0;
};

/* Returns the surface where the distance is 0. Connected parts with fewer than 60 triangles are left out.
 * Throws std::runtime_error when the surface is empty or leaves the bounds. */
Mesh mesh_of(const MeshRequest &request);

/* Returns an empty text if every edge has exactly two triangles, which run along it in opposite
 * directions. Otherwise returns the first fault in words. */
std::string closed_mesh_fault(const Mesh &mesh);

double mesh_volume_mm3(const Mesh &mesh);

} // namespace anatomy
