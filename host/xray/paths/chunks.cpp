// Cuts the mesh of a body into chunks of neighbouring triangles, so that a chunk outside the picture can be
// skipped as a whole.
#include "host/xray/paths/materials.hpp"
#include "host/xray/paths/meshes.hpp"
#include "host/xray/paths/trabeculae.hpp"
#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>

namespace crn
{
namespace
{

// Interleaves the bits of three coordinates of ten bits, so that positions near each other in space get
// similar keys.
std::uint32_t morton_key(const Eigen::Vector3i &cell)
{
    std::uint32_t key = 0;
    for (int bit = 0; bit < 10; ++bit)
        for (int axis = 0; axis < 3; ++axis)
            key |= ((static_cast<std::uint32_t>(cell[axis]) >> bit) & 1u) << (3 * bit + axis);
    return key;
}

std::vector<std::uint32_t> triangle_order(const Body &body)
{
    Eigen::Vector3i low = body.vertices_um.front(), high = low;
    for (const Eigen::Vector3i &v : body.vertices_um) {
        low = low.cwiseMin(v);
        high = high.cwiseMax(v);
    }
    const std::int64_t cell_um = std::max<std::int64_t>((high - low).maxCoeff() / 1023 + 1, 1);
    std::vector<std::uint32_t> keys(body.triangles.size()), order(body.triangles.size());
    for (std::size_t i = 0; i < keys.size(); ++i) {
        Eigen::Vector3i cell;
        for (int axis = 0; axis < 3; ++axis) {
            std::int64_t sum = 0;
            for (std::uint32_t corner : body.triangles[i]) sum += body.vertices_um[corner][axis] - low[axis];
            cell[axis] = static_cast<int>(sum / 3 / cell_um);
        }
        keys[i] = morton_key(cell);
    }
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return keys[a] < keys[b]; });
    return order;
}

void set_sphere_of_vertices(const BodyMeshes &meshes, MeshChunk &chunk)
{
    const Eigen::Vector3f *vertices = meshes.vertices_um.data() + chunk.vertex_begin;
    Eigen::Vector3f low = vertices[0], high = vertices[0];
    for (std::uint32_t i = 1; i < chunk.vertex_count; ++i) {
        low = low.cwiseMin(vertices[i]);
        high = high.cwiseMax(vertices[i]);
    }
    set_sphere(chunk, low, high);
}

int channel_of(BodyMeshes &meshes, MeshChannel wanted)
{
    for (std::size_t i = 0; i < meshes.channels.size(); ++i)
        if (meshes.channels[i].own == wanted.own && meshes.channels[i].parent == wanted.parent &&
            meshes.channels[i].scale_q10 == wanted.scale_q10)
            return static_cast<int>(i);
    meshes.channels.push_back(wanted);
    return static_cast<int>(meshes.channels.size()) - 1;
}

} // namespace

void set_sphere(MeshChunk &chunk, const Eigen::Vector3f &low_um, const Eigen::Vector3f &high_um)
{
    chunk.centre_um = 0.5f * (low_um + high_um);
    chunk.radius_um = 0.5f * (high_um - low_um).norm() + 10.0f; // 10 um cover the rounding of the centre
}

void append_body(BodyMeshes &meshes, const Body &body, int own, int parent)
{
    const bool is_in_bone = parent == static_cast<int>(Material::bone_cortical);
    const int channel =
        channel_of(meshes, {own, parent, is_in_bone ? spongy_scale_q10(body.material) : 1024});
    const int index = static_cast<int>(meshes.channel_of_body.size());
    meshes.channel_of_body.push_back(channel);
    meshes.vertex_counts.push_back(body.vertices_um.size());
    if (body.triangles.empty()) return;
    const std::vector<std::uint32_t> order = triangle_order(body);
    for (std::size_t begin = 0; begin < order.size(); begin += mesh_chunk_triangles) {
        MeshChunk chunk;
        chunk.vertex_begin = static_cast<std::uint32_t>(meshes.vertices_um.size());
        chunk.triangle_begin = static_cast<std::uint32_t>(meshes.triangles.size());
        chunk.triangle_count =
            static_cast<std::uint32_t>(std::min<std::size_t>(mesh_chunk_triangles, order.size() - begin));
        chunk.channel = channel;
        chunk.body = index;
        const bool has_grain = body.is_trabecular && own != parent;
        if (has_grain) chunk.grain_begin = static_cast<std::uint32_t>(meshes.grain_places.size());
        std::unordered_map<std::uint32_t, std::uint16_t> local;
        for (std::uint32_t i = 0; i < chunk.triangle_count; ++i) {
            std::array<std::uint16_t, 3> triangle;
            for (int corner = 0; corner < 3; ++corner) {
                std::uint32_t vertex = body.triangles[order[begin + i]][corner];
                auto [place, is_new] = local.try_emplace(vertex, static_cast<std::uint16_t>(local.size()));
                if (is_new) {
                    meshes.vertices_um.push_back(body.vertices_um[vertex].cast<float>());
                    meshes.body_vertex.push_back(vertex);
                    if (has_grain) meshes.grain_places.push_back(grain_place(body.vertices_um[vertex]));
                }
                triangle[corner] = place->second;
            }
            meshes.triangles.push_back(triangle);
        }
        chunk.vertex_count = static_cast<std::uint32_t>(local.size());
        set_sphere_of_vertices(meshes, chunk);
        meshes.chunks.push_back(chunk);
    }
}

void move_body(BodyMeshes &meshes, int body, std::span<const Eigen::Vector3i> vertices_um)
{
    for (MeshChunk &chunk : meshes.chunks) {
        if (chunk.body != body) continue;
        for (std::uint32_t i = chunk.vertex_begin; i < chunk.vertex_begin + chunk.vertex_count; ++i)
            meshes.vertices_um[i] = vertices_um[meshes.body_vertex[i]].cast<float>();
        set_sphere_of_vertices(meshes, chunk);
    }
}

std::vector<Eigen::Vector3i> body_vertices_um(const BodyMeshes &meshes, int body)
{
    std::vector<Eigen::Vector3i> vertices(meshes.vertex_counts[body], Eigen::Vector3i::Zero());
    for (const MeshChunk &chunk : meshes.chunks) {
        if (chunk.body != body) continue;
        for (std::uint32_t i = chunk.vertex_begin; i < chunk.vertex_begin + chunk.vertex_count; ++i)
            vertices[meshes.body_vertex[i]] = meshes.vertices_um[i].cast<int>();
    }
    return vertices;
}

} // namespace crn
