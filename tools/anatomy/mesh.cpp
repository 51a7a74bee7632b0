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

/* Fills blocks of the grid with values of a distance function. Exact distances are needed only near the
 * surface. If the middle of a group of grid points is far enough from the surface, all points of the group
 * and their neighbours are on one side of the surface, and get the same distance: the width of the level
 * set's band, with the sign at the middle. */
class BlockFiller
{
  public:
    BlockFiller(const Cell &block, const MeshRequest &request)
        : voxel_(request.voxel_mm), band_(BAND_VOXELS * request.voxel_mm),
          distance_(request.distance_in(block_box(block, voxel_), band_)),
          origin_(Vec3(block[0], block[1], block[2]) * BLOCK)
    {
    }

    crn::mesh::Block filled()
    {
        constexpr int LARGE = 4;
        for (int z = 0; z < BLOCK; z += LARGE)
            for (int y = 0; y < BLOCK; y += LARGE)
                for (int x = 0; x < BLOCK; x += LARGE) fill_group(x, y, z, LARGE);
        return block_;
    }

  private:
    double at(double x, double y, double z) const
    {
        return distance_(Vec3((origin_ + Vec3(x, y, z)) * voxel_));
    }

    /* A group whose middle is near the surface is divided into eight, or in the end into its points. */
    void fill_group(int x, int y, int z, int edge)
    {
        // The farthest point of a group lies half the group's diagonal from its middle, and its farthest
        // neighbour one voxel's diagonal more.
        const double far = STEEPEST * (0.5 * (edge - 1) + 1.0) * std::sqrt(3.0) * voxel_;
        const double middle_at = 0.5 * (edge - 1);
        const double middle = at(x + middle_at, y + middle_at, z + middle_at);
        const bool is_far = std::abs(middle) > far;
        const double value = std::copysign(band_, middle);
        const int half = edge / 2;
        for (int k = 0; k < 8 && !is_far && edge > 2; k++)
            fill_group(x + half * (k % 2), y + half * (k / 2 % 2), z + half * (k / 4), half);
        if (!is_far && edge > 2) return;
        for (int c = z; c < z + edge; c++)
            for (int b = y; b < y + edge; b++)
                for (int a = x; a < x + edge; a++)
                    block_[static_cast<size_t>(a + BLOCK * (b + BLOCK * c))] =
                        is_far ? value : std::clamp(at(a, b, c), -band_, band_);
    }

    double voxel_, band_;
    Distance distance_;
    Vec3 origin_;
    crn::mesh::Block block_;
};

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
                if (std::abs(distance(centre)) < reach_mm)
                    level.set({x, y, z}, BlockFiller({x, y, z}, request).filled());
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

void append_pieces(const Mesh &pieces, Mesh &mesh)
{
    const auto first = static_cast<uint32_t>(mesh.vertices_mm.size());
    mesh.vertices_mm.insert(mesh.vertices_mm.end(), pieces.vertices_mm.begin(), pieces.vertices_mm.end());
    for (const auto &t : pieces.triangles)
        mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
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
        if (request.more) append_pieces(request.more(), mesh);
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
        const auto fault = [&](const char *what) {
            return "edge " + std::to_string(from) + "-" + std::to_string(to) + what;
        };
        if (i > 0 && edges[i] == edges[i - 1]) return fault(" has more than two triangles");
        if (!std::binary_search(edges.begin(), edges.end(), static_cast<uint64_t>(to) << 32 | from))
            return fault(" is open");
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
