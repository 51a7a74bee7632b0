#include "tools/mesh/pieces.hpp"
#include <algorithm>
#include <numeric>

namespace crn::mesh
{

std::vector<uint32_t> pieces_of(size_t vertex_count, const std::vector<Triangle> &triangles)
{
    std::vector<uint32_t> parent(vertex_count);
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](uint32_t vertex) {
        while (parent[vertex] != vertex) vertex = parent[vertex] = parent[parent[vertex]];
        return vertex;
    };
    for (const Triangle &t : triangles)
        for (size_t k : {1, 2}) parent[root(t[k])] = root(t[0]);
    for (uint32_t vertex = 0; vertex < parent.size(); ++vertex) parent[vertex] = root(vertex);
    return parent;
}

void drop_small_pieces(std::vector<Eigen::Vector3d> &vertices, std::vector<Triangle> &triangles, size_t least,
                       double share)
{
    const std::vector<uint32_t> piece = pieces_of(vertices.size(), triangles);
    std::vector<size_t> size(vertices.size(), 0);
    for (const Triangle &t : triangles) ++size[piece[t[0]]];
    const size_t largest = size.empty() ? 0 : *std::max_element(size.begin(), size.end());
    std::erase_if(triangles, [&](const Triangle &t) {
        const size_t own = size[piece[t[0]]];
        return own < least || static_cast<double>(own) < share * static_cast<double>(largest);
    });
    drop_unused(vertices, triangles);
}

void drop_unused(std::vector<Eigen::Vector3d> &vertices, std::vector<Triangle> &triangles)
{
    std::vector<uint32_t> renamed(vertices.size(), UINT32_MAX);
    std::vector<Eigen::Vector3d> used;
    for (Triangle &t : triangles)
        for (uint32_t &vertex : t) {
            if (renamed[vertex] == UINT32_MAX) {
                renamed[vertex] = static_cast<uint32_t>(used.size());
                used.push_back(vertices[vertex]);
            }
            vertex = renamed[vertex];
        }
    vertices = std::move(used);
}

} // namespace crn::mesh
