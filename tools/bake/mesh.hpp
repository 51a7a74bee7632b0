// Loads, checks, closes and writes a triangle mesh in the patient's millimetres.
#pragma once
#include "tools/bake/scene_text.hpp"
#include "tools/mesh/progress.hpp"

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace crn::bake
{

constexpr double mesh_extent_min_mm = 5.0;
constexpr double mesh_extent_max_mm = 3000.0;

using Triangle = std::array<std::uint32_t, 3>;

struct Mesh {
    std::string name; // file, for messages
    std::vector<Eigen::Vector3d> vertices_mm;
    std::vector<Triangle> triangles;
    std::vector<std::string> notes; // the repairs that were made
};

std::string place_text(const Eigen::Vector3d &p_mm); // "(1.0, 2.0, 3.0) mm"

// Reads a mesh (mesh_file.hpp), converts it to the patient's coordinates, and merges vertices at equal
// positions. Throws Fault for a mesh that is unreadable, empty or too large, has infinite numbers or missing
// corners, or has a size that suggests another unit.
Mesh load_mesh(const MeshText &text);

// Checks that the mesh has a plausible size, has only finite coordinates, and is not empty. The error message
// about a wrong unit of the mesh advises the user to set the key `unit`.
void check_extent(const Mesh &mesh, const std::string &unit);

// Merges vertices at equal positions and drops triangles without area, and notes both changes in the report.
void weld(Mesh &mesh);

// Checks that the mesh is closed: every edge must belong to exactly two triangles, which run along this edge
// in opposite directions. Openings of the mesh are closed by a cap if the parameter `cap` permits a cap. If
// the volume of the mesh is negative, the function reverses all its triangles and notes this reversal in the
// report. Throws Fault otherwise.
void check_closed(Mesh &mesh, Cap cap);

// Only caps the openings. The mesh may be non-manifold and may cross itself, because its surface is remade
// afterwards (solid.hpp).
void cap_openings(Mesh &mesh, Cap cap);

// Throws Fault when triangles cross without sharing a vertex; the message gives the first pair and the number
// of such pairs.
void check_crossing(const Mesh &mesh, Progress &progress);

double volume_mm3(const Mesh &mesh);
double area_mm2(const Mesh &mesh);

void write_ply(const Mesh &mesh, const std::filesystem::path &file);

} // namespace crn::bake
