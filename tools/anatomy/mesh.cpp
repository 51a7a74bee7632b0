#include "tools/anatomy/mesh.hpp"
#include "tools/mesh/level_set/level_set.hpp"
#include "tools/mesh/pieces.hpp"
#include "tools/mesh/simplify.hpp"
#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace anatomy
{

namespace
{

using crn::mesh::Cell;
constexpr int BLOCK = crn::mesh::block_edge;
constexpr double BAND_VOXELS = 3.0;
/* The distances that smooth shapes return are estimates. For the shapes that are used here, the estimated
 * distance changes by at most 1.5 mm when the point moves by 1 mm. */
constexpr double STEEPEST = 1.5;

/* Returns the box of one block of the grid with a margin of one voxel. */
Box block_box(const Cell &block, double voxel_mm)
{
    Box box;
    box.low = Vec3(BLOCK * block[0] - 1, BLOCK * block[1] - 1, BLOCK * block[2] - 1) * voxel_mm;
    box.high = box.low + Vec3::Constant((BLOCK + 1) * voxel_mm);
    return box;
}

/* Fills one block of the grid with values of the distance function. Exact distances are needed only near the
 * surface. If the middle of a group of grid points is far enough from the surface, all points of the group
 * and their neighbours are on one side of the surface. All points of a group far from the surface get the
 * same distance: the width of the level set's band, with the sign at the group's middle. */
crn::mesh::Block block_of(const Cell &block, const MeshRequest &request)
{
    constexpr int GROUP = 2;
    const double voxel = request.voxel_mm, band = BAND_VOXELS * voxel;
    // A group of points counts as far from the surface if the estimated distance at its middle exceeds `far`.
    // The value `far` is STEEPEST times the sum of half the group's diagonal and one voxel's diagonal.
    const double far = STEEPEST * (0.5 * (GROUP - 1) + 1.0) * std::sqrt(3.0) * voxel;
    const Distance distance = request.distance_in(block_box(block, voxel), band);
    const Vec3 origin = Vec3(block[0], block[1], block[2]) * BLOCK;
    crn::mesh::Block made;
    for (int group = 0; group < BLOCK * BLOCK * BLOCK; group += GROUP * GROUP * GROUP) {
        const int n = group / (GROUP * GROUP * GROUP), side = BLOCK / GROUP;
        const int first[3] = {GROUP * (n % side), GROUP * (n / side % side), GROUP * (n / side / side)};
        const auto point_at = [&](double x, double y, double z) {
            return Vec3((origin + Vec3(first[0] + x, first[1] + y, first[2] + z)) * voxel);
        };
        constexpr double MIDDLE = 0.5 * (GROUP - 1);
        const double middle = distance(point_at(MIDDLE, MIDDLE, MIDDLE));
        for (int k = 0; k < GROUP * GROUP * GROUP; k++) {
            const int x = k % GROUP, y = k / GROUP % GROUP, z = k / GROUP / GROUP;
            made[first[0] + x + BLOCK * (first[1] + y + BLOCK * (first[2] + z))] =
                std::abs(middle) > far ? std::copysign(band, middle)
                                       : std::clamp(distance(point_at(x, y, z)), -band, band);
        }
    }
    return made;
}

/* Makes the level set. Blocks whose centre is far from the surface are skipped; fill_signs() later gives
 * these blocks their sign. The level set is measured in voxels, so the vertices of its surface must be
 * multiplied by the edge length of a voxel. */
crn::mesh::LevelSet level_set(const MeshRequest &request)
{
    // For the centres of all blocks in a column of the grid, the code uses one distance function.
    const double block_mm = BLOCK * request.voxel_mm;
    crn::mesh::LevelSet level(1.0, BAND_VOXELS * request.voxel_mm);
    const double reach_mm = STEEPEST * (0.5 * std::sqrt(3.0) * block_mm) + request.voxel_mm;
    const Vec3 first = ((request.bounds.low / block_mm).array().floor() - 1.0).matrix();
    const Vec3 last = ((request.bounds.high / block_mm).array().ceil() + 1.0).matrix();
    for (int x = static_cast<int>(first.x()); x <= last.x(); x++)
        for (int y = static_cast<int>(first.y()); y <= last.y(); y++) {
            Box column;
            column.include(Vec3(x, y, first.z()) * block_mm, 0.0);
            column.include(Vec3(x + 1, y + 1, last.z() + 1) * block_mm, 0.0);
            const Distance distance = request.distance_in(column, reach_mm);
            for (int z = static_cast<int>(first.z()); z <= last.z(); z++) {
                const Vec3 centre = (Vec3(x, y, z) + Vec3::Constant(0.5)) * block_mm;
                if (std::abs(distance(centre)) < reach_mm) level.set({x, y, z}, block_of({x, y, z}, request));
            }
        }
    level.fill_signs();
    return level;
}

/* Moves a vertex of the level set's surface onto the true surface by one Newton step. */
Vec3 onto_surface(const Distance &distance, double voxel_mm, const Vec3 &point)
{
    const double step = 0.1 * voxel_mm;
    const double value = distance(point);
    Vec3 gradient;
    for (int axis = 0; axis < 3; axis++) {
        Vec3 moved = point;
        moved[axis] += step;
        gradient[axis] = (distance(moved) - value) / step;
    }
    const double limit = 0.25 * voxel_mm;
    return point - gradient * std::clamp(value / std::max(gradient.squaredNorm(), 0.25), -limit, limit);
}

Mesh surface_of(const crn::mesh::LevelSet &level, const MeshRequest &request)
{
    crn::mesh::QuadSurface surface = level.surface();
    // The vertices of one block follow each other in the list, so a new local distance function is needed
    // only for a new block.
    std::optional<Cell> block;
    Distance distance;
    for (Vec3 &vertex : surface.vertices) {
        Cell at;
        for (int axis = 0; axis < 3; axis++) at[axis] = static_cast<int>(std::floor(vertex[axis] / BLOCK));
        if (at != block) {
            distance = request.distance_in(block_box(at, request.voxel_mm), BAND_VOXELS * request.voxel_mm);
            block = at;
        }
        vertex = onto_surface(distance, request.voxel_mm, vertex * request.voxel_mm);
    }
    return {surface.vertices, divided_shorter(surface)};
}

} // namespace

LocalDistance local_distance(const Solid &solid)
{
    return [solid](const Box &box, double reach_mm) -> Distance {
        return [near = solid.near(box, reach_mm)](const Vec3 &p) { return near.distance(p); };
    };
}

Mesh mesh_of(const MeshRequest &request)
{
    // A saddle of the surface exactly at a grid point can produce an edge that belongs to four triangles. A
    // tiny offset, which the code adds to the distance, avoids edges that belong to four triangles.
    constexpr int ATTEMPTS = 4;
    constexpr size_t CRUMB_TRIANGLES = 60;
    std::string fault;
    for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
        MeshRequest nudged = request;
        const double offset_mm = attempt * 0.013 * request.voxel_mm;
        if (attempt > 0)
            nudged.distance_in = [&](const Box &box, double reach_mm) -> Distance {
                const Distance distance = request.distance_in(box, reach_mm);
                return [=](const Vec3 &point) { return distance(point) + offset_mm; };
            };
        Mesh mesh = surface_of(level_set(nudged), nudged);
        crn::mesh::drop_small_pieces(mesh.vertices_mm, mesh.triangles, CRUMB_TRIANGLES, 0);
        if (mesh.triangles.empty() && request.may_be_empty) return {};
        if (mesh.triangles.empty()) throw std::runtime_error("the surface is empty");
        fault = closed_mesh_fault(mesh);
        if (!fault.empty()) continue;
        if (request.error_mm > 0.0) crn::mesh::simplify(mesh.vertices_mm, mesh.triangles, request.error_mm);
        if (request.shortest_mm > 0.0)
            crn::mesh::drop_short_edges(mesh.vertices_mm, mesh.triangles, request.shortest_mm);
        return mesh;
    }
    throw std::runtime_error("the surface does not close: " + fault);
}

std::string closed_mesh_fault(const Mesh &mesh)
{
    std::vector<uint64_t> edges;
    edges.reserve(mesh.triangles.size() * 3);
    for (const auto &t : mesh.triangles)
        for (int i = 0; i < 3; i++) edges.push_back(static_cast<uint64_t>(t[i]) << 32 | t[(i + 1) % 3]);
    std::sort(edges.begin(), edges.end());
    for (size_t i = 0; i < edges.size(); i++) {
        const auto from = static_cast<uint32_t>(edges[i] >> 32), to = static_cast<uint32_t>(edges[i]);
        const std::string name = "edge " + std::to_string(from) + "-" + std::to_string(to);
        if (i > 0 && edges[i] == edges[i - 1]) return name + " has more than two triangles";
        if (!std::binary_search(edges.begin(), edges.end(), static_cast<uint64_t>(to) << 32 | from))
            return name + " is open";
    }
    return "";
}

double mesh_volume_mm3(const Mesh &mesh)
{
    double six_volumes = 0.0;
    for (const auto &t : mesh.triangles)
        six_volumes += mesh.vertices_mm[t[0]].dot(mesh.vertices_mm[t[1]].cross(mesh.vertices_mm[t[2]]));
    return six_volumes / 6.0;
}

} // namespace anatomy
