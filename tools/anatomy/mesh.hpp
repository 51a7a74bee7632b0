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

/* Returns a distance function for points inside a box. The value of the distance function is correct wherever
 * the distance is below reach_mm. Only a few shapes of a body determine the distance near one point. The
 * program finds the shapes near a block once per block of the grid instead of once per point, which makes
 * meshing many times faster. */
using LocalDistance = std::function<Distance(const Box &box, double reach_mm)>;
LocalDistance local_distance(const Solid &solid);

/* Describes a solid and the required fineness of its mesh. Simplification may move the surface by at most
 * error_mm; if error_mm is 0, the mesh is not simplified. Edges of the mesh that are shorter than shortest_mm
 * are collapsed. */
struct MeshRequest {
    Box bounds;
    LocalDistance distance_in;
    double voxel_mm = 1.5;
    double error_mm = 0.15;
    double shortest_mm = 0;
    bool may_be_empty = false;            // an empty mesh is no failure
    std::function<Mesh()> more = nullptr; // makes closed pieces that join the mesh as they are
};

/* Returns the mesh of the surface on which the distance is 0. Connected parts of the mesh that have fewer
 * than 60 triangles are left out. Throws std::runtime_error when the surface is empty, unless it may be, or
 * extends beyond the given bounds. */
Mesh mesh_of(const MeshRequest &request);

/* Returns an empty text if every edge of the mesh belongs to exactly two triangles, which traverse the edge
 * in opposite directions. If the mesh has a fault, the check returns a description of the first fault. */
std::string closed_mesh_fault(const Mesh &mesh);

double mesh_volume_mm3(const Mesh &mesh);

} // namespace anatomy
