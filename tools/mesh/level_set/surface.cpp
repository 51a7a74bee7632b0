#include "tools/mesh/level_set/surface.hpp"
#include <algorithm>
#include <numeric>
#include <tuple>

namespace crn::mesh
{
namespace
{

// The corners of all triangles are numbered: corner c of triangle t has the number 3 t + c. Corners that
// continue to share a vertex are joined into one group.
struct Corners {
    std::vector<std::uint32_t> parent;
    std::uint32_t root(std::uint32_t corner)
    {
        while (parent[corner] != corner) corner = parent[corner] = parent[parent[corner]];
        return corner;
    }
};

struct HalfEdge {
    std::uint32_t low, high, triangle, side;
    bool forward;
};

std::vector<HalfEdge> half_edges(const std::vector<Triangle> &triangles)
{
    std::vector<HalfEdge> edges;
    edges.reserve(3 * triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
            edges.push_back({std::min(a, b), std::max(a, b), t, k, a < b});
        }
    std::sort(edges.begin(), edges.end(), [](const HalfEdge &a, const HalfEdge &b) {
        return std::tie(a.low, a.high, a.forward, a.triangle) <
               std::tie(b.low, b.high, b.forward, b.triangle);
    });
    return edges;
}

// Joins the corners of two triangles at both ends of their common edge.
void join_across(Corners &corners, const HalfEdge &one, const HalfEdge &other)
{
    const auto corner = [](const HalfEdge &edge, bool low) {
        const bool first = edge.forward == low;
        return 3 * edge.triangle + (first ? edge.side : (edge.side + 1) % 3);
    };
    for (bool low : {true, false})
        corners.parent[corners.root(corner(one, low))] = corners.root(corner(other, low));
}

} // namespace

std::vector<Triangle> divided(const QuadSurface &surface)
{
    std::vector<Triangle> triangles;
    triangles.reserve(2 * surface.quads.size());
    for (const auto &q : surface.quads) {
        triangles.push_back({q[3], q[1], q[2]});
        triangles.push_back({q[3], q[0], q[1]});
    }
    return triangles;
}

std::vector<Triangle> divided_shorter(const QuadSurface &surface)
{
    std::vector<Triangle> triangles;
    triangles.reserve(2 * surface.quads.size());
    const auto &v = surface.vertices;
    for (const auto &q : surface.quads) {
        const bool is_first = (v[q[0]] - v[q[2]]).squaredNorm() <= (v[q[1]] - v[q[3]]).squaredNorm();
        if (is_first) {
            triangles.push_back({q[0], q[1], q[2]});
            triangles.push_back({q[0], q[2], q[3]});
        } else {
            triangles.push_back({q[1], q[2], q[3]});
            triangles.push_back({q[1], q[3], q[0]});
        }
    }
    return triangles;
}

void separate_sheets(std::vector<Eigen::Vector3d> &vertices, std::vector<Triangle> &triangles)
{
    Corners corners;
    corners.parent.resize(3 * triangles.size());
    std::iota(corners.parent.begin(), corners.parent.end(), 0u);
    const std::vector<HalfEdge> edges = half_edges(triangles);
    for (std::size_t i = 0, end; i < edges.size(); i = end) {
        for (end = i;
             end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high;)
            ++end;
        // For each edge, the sorted list contains first the backward half edges and then equally many forward
        // half edges. The code pairs the n-th backward half edge with the n-th forward half edge.
        const std::size_t half = (end - i) / 2;
        for (std::size_t n = 0; n < half; ++n) join_across(corners, edges[i + n], edges[i + half + n]);
    }
    std::vector<std::uint32_t> vertex_of(corners.parent.size(), UINT32_MAX);
    std::vector<Eigen::Vector3d> made;
    std::vector<Triangle> renamed = triangles;
    for (std::uint32_t t = 0; t < renamed.size(); ++t)
        for (std::uint32_t k = 0; k < 3; ++k) {
            std::uint32_t &vertex = vertex_of[corners.root(3 * t + k)];
            if (vertex == UINT32_MAX) {
                vertex = static_cast<std::uint32_t>(made.size());
                made.push_back(vertices[triangles[t][k]]);
            }
            renamed[t][k] = vertex;
        }
    vertices = std::move(made);
    triangles = std::move(renamed);
}

} // namespace crn::mesh
