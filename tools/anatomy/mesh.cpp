#include "tools/anatomy/mesh.hpp"
#include "tools/mesh/simplify.hpp"
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <openvdb/openvdb.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <stdexcept>

namespace anatomy
{

namespace
{

constexpr int BLOCK = 8; // voxels along one side of an OpenVDB leaf
constexpr double BAND_VOXELS = 3.0;
/* Distances of smooth shapes are estimates; 1.5 covers the steepest underestimate of the shapes used here. */
constexpr double STEEPEST = 1.5;

/* Returns the box of one leaf of the grid with a margin of one voxel. */
Box block_box(const openvdb::Coord &origin, double voxel_mm)
{
    Box box;
    box.low = Vec3(origin.x() - 1, origin.y() - 1, origin.z() - 1) * voxel_mm;
    box.high = box.low + Vec3::Constant((BLOCK + 1) * voxel_mm);
    return box;
}

/* Fills one leaf from the distance function. Exact values are needed only beside the surface. A group of
 * points gets the band's value, with the sign of its middle, when its middle is so far from the surface
 * that no point's neighbour lies beyond it. */
void fill_block(openvdb::FloatGrid::Accessor &access, const openvdb::Coord &origin,
                const MeshRequest &request)
{
    constexpr int GROUP = 2;
    const double voxel = request.voxel_mm, band = BAND_VOXELS * voxel;
    // Half a group's diagonal plus a voxel's diagonal, by the steepest estimate (level_set()).
    const double far = STEEPEST * (0.5 * (GROUP - 1) + 1.0) * std::sqrt(3.0) * voxel;
    const Distance distance = request.distance_in(block_box(origin, voxel), band);
    auto *leaf = access.touchLeaf(origin);
    const auto point_at = [&](const openvdb::Coord &at, double off) {
        return Vec3((Vec3(at.x(), at.y(), at.z()) + Vec3::Constant(off)) * voxel);
    };
    for (int group = 0; group < BLOCK * BLOCK * BLOCK; group += GROUP * GROUP * GROUP) {
        const int n = group / (GROUP * GROUP * GROUP), side = BLOCK / GROUP;
        const openvdb::Coord first =
            origin.offsetBy(GROUP * (n % side), GROUP * (n / side % side), GROUP * (n / side / side));
        const double middle = distance(point_at(first, 0.5 * (GROUP - 1)));
        for (int k = 0; k < GROUP * GROUP * GROUP; k++) {
            const openvdb::Coord at = first.offsetBy(k % GROUP, k / GROUP % GROUP, k / GROUP / GROUP);
            const double value = std::abs(middle) > far ? std::copysign(band, middle)
                                                        : std::clamp(distance(point_at(at, 0)), -band, band);
            leaf->setValueOn(at, static_cast<float>(value));
        }
    }
}

/* Blocks whose centre is far from the surface are skipped; the flood fill gives them their sign. */
openvdb::FloatGrid::Ptr level_set(const MeshRequest &request)
{
    // Columns of blocks share one distance function when their centres are tested.
    const double block_mm = BLOCK * request.voxel_mm;
    auto grid = openvdb::FloatGrid::create(static_cast<float>(BAND_VOXELS * request.voxel_mm));
    auto access = grid->getAccessor();
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
                if (std::abs(distance(centre)) < reach_mm)
                    fill_block(access, openvdb::Coord(x * BLOCK, y * BLOCK, z * BLOCK), request);
            }
        }
    openvdb::tools::signedFloodFill(grid->tree());
    return grid;
}

/* One Newton step moves a vertex of the grid's surface onto the true surface. */
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

Mesh surface_of(const openvdb::FloatGrid &grid, const MeshRequest &request)
{
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec4I> quads;
    openvdb::tools::volumeToMesh(grid, points, quads, 0.0);
    Mesh mesh;
    mesh.vertices_mm.reserve(points.size());
    // The points come block by block, so the local distance function is renewed when the block changes.
    openvdb::Coord block = openvdb::Coord::max();
    Distance distance;
    for (const auto &point : points) {
        const openvdb::Coord at = openvdb::Coord::floor(point) & ~(BLOCK - 1);
        if (at != block) {
            distance = request.distance_in(block_box(at, request.voxel_mm), BAND_VOXELS * request.voxel_mm);
            block = at;
        }
        const Vec3 place = Vec3(point.x(), point.y(), point.z()) * request.voxel_mm;
        mesh.vertices_mm.push_back(onto_surface(distance, request.voxel_mm, place));
    }
    for (const auto &quad : quads) {
        // The quadrangle is split along its shorter diagonal, counter-clockwise as seen from outside.
        const auto &v = mesh.vertices_mm;
        const bool first_diagonal =
            (v[quad[0]] - v[quad[2]]).squaredNorm() <= (v[quad[1]] - v[quad[3]]).squaredNorm();
        if (first_diagonal) {
            mesh.triangles.push_back({quad[0], quad[1], quad[2]});
            mesh.triangles.push_back({quad[0], quad[2], quad[3]});
        } else {
            mesh.triangles.push_back({quad[1], quad[2], quad[3]});
            mesh.triangles.push_back({quad[1], quad[3], quad[0]});
        }
    }
    return mesh;
}

/* Keeps only the connected surfaces that have enough triangles. */
void drop_crumbs(Mesh &mesh)
{
    constexpr uint32_t CRUMB_TRIANGLES = 60;
    std::vector<uint32_t> parent(mesh.vertices_mm.size());
    std::iota(parent.begin(), parent.end(), 0u);
    auto root = [&](uint32_t vertex) {
        while (parent[vertex] != vertex) vertex = parent[vertex] = parent[parent[vertex]];
        return vertex;
    };
    for (const auto &t : mesh.triangles) {
        parent[root(t[1])] = root(t[0]);
        parent[root(t[2])] = root(t[0]);
    }
    std::vector<uint32_t> size(parent.size(), 0);
    for (const auto &t : mesh.triangles) size[root(t[0])]++;
    std::vector<uint32_t> renamed(parent.size(), UINT32_MAX);
    Mesh kept;
    for (auto t : mesh.triangles) {
        if (size[root(t[0])] < CRUMB_TRIANGLES) continue;
        for (uint32_t &vertex : t) {
            if (renamed[vertex] == UINT32_MAX) {
                renamed[vertex] = static_cast<uint32_t>(kept.vertices_mm.size());
                kept.vertices_mm.push_back(mesh.vertices_mm[vertex]);
            }
            vertex = renamed[vertex];
        }
        kept.triangles.push_back(t);
    }
    mesh = std::move(kept);
}

} // namespace

Mesh mesh_of(const MeshRequest &request)
{
    // A grid point exactly on a saddle can pinch the surface; a tiny offset avoids that.
    constexpr int ATTEMPTS = 4;
    std::string fault;
    for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
        MeshRequest nudged = request;
        const double offset_mm = attempt * 0.013 * request.voxel_mm;
        if (attempt > 0)
            nudged.distance_in = [&](const Box &box, double reach_mm) -> Distance {
                const Distance distance = request.distance_in(box, reach_mm);
                return [=](const Vec3 &point) { return distance(point) + offset_mm; };
            };
        Mesh mesh = surface_of(*level_set(nudged), nudged);
        drop_crumbs(mesh);
        if (mesh.triangles.empty()) throw std::runtime_error("the surface is empty");
        fault = closed_mesh_fault(mesh);
        if (!fault.empty()) continue;
        if (request.error_mm > 0.0) crn::mesh::simplify(mesh.vertices_mm, mesh.triangles, request.error_mm);
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
