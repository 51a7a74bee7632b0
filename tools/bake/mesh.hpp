// A triangle mesh in patient millimetres: loading, checking, closing, writing.
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
    std::vector<std::string> notes; // what was repaired
};

std::string place_text(const Eigen::Vector3d &p_mm); // "(1.0, 2.0, 3.0) mm"

// Reads (mesh_file.hpp), places, and welds equal vertices. Throws Fault for what no mesh may have:
// unreadable, empty, too many triangles, numbers that are not finite, corners that are not there, a size that
// suggests another unit.
Mesh load_mesh(const MeshText &text);

// Finite, of a possible size, not empty. `unit` for the advice.
void check_extent(const Mesh &mesh, const std::string &unit);

// One vertex for equal positions; triangles without area dropped (noted).
void weld(Mesh &mesh);

// Closed, every edge in exactly two triangles of opposite sense; openings are capped as `cap` allows. Turns a
// mesh inside out when its volume is negative (noted). Throws Fault otherwise.
void check_closed(Mesh &mesh, Cap cap);

// Only the openings, for a mesh whose surface is made anew afterwards (solid.hpp): it may be non-manifold and
// cross itself.
void cap_openings(Mesh &mesh, Cap cap);

// Pairs of triangles that cross without sharing a vertex: throws Fault with the first pair and the number.
void check_crossing(const Mesh &mesh, Progress &progress);

double volume_mm3(const Mesh &mesh);
double area_mm2(const Mesh &mesh);

void write_ply(const Mesh &mesh, const std::filesystem::path &file);

} // namespace crn::bake
