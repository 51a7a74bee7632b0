// Holds the bodies of a scene in the form in which they are drawn: as chunks of neighbouring triangles, so
// that a chunk outside the picture is skipped as a whole. The meshes of a scene's bodies are made once, and
// then any number of threads and back ends may read them.
#pragma once
#include "host/model/bodies.hpp"
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace crn
{

// A channel is one picture of depth sums: all bodies of the same material that lie in bodies of the same
// other material share a channel, if they have the same density. The sums of a channel are added to the path
// lengths in the bodies' own material, and subtracted from those in the surrounding material (the parent).
struct MeshChannel {
    int own = 0;          // material
    int parent = -1;      // material, -1: air
    int scale_q10 = 1024; // of its sums, for spongy bone of another density (materials.hpp)
};

// Multiplies a depth sum by such a scale, and rounds to nearest. Whole and broken millimetres are multiplied
// separately, so that nothing overflows.
inline std::int32_t scaled_sum(std::int32_t sum, int scale_q10)
{
    return (sum >> 10) * scale_q10 + (((sum & 1023) * scale_q10 + 512) >> 10);
}

// A chunk consists of about a hundred neighbouring triangles and the vertices that they use.
struct MeshChunk {
    std::uint32_t vertex_begin = 0, vertex_count = 0;
    std::uint32_t triangle_begin = 0, triangle_count = 0;
    int channel = 0;
    int body = 0; // index in Bodies
    // Where its vertices begin in BodyMeshes::grain_places, if its faces have the texture of trabeculae.
    std::optional<std::uint32_t> grain_begin = {};
    Eigen::Vector3f centre_um = Eigen::Vector3f::Zero();
    float radius_um = 0.0f;
};

struct BodyMeshes {
    std::vector<MeshChannel> channels;
    std::vector<int> channel_of_body;
    std::vector<std::size_t> vertex_counts;   // of each body
    std::vector<MeshChunk> chunks;            // body after body
    std::vector<Eigen::Vector3f> vertices_um; // whole micrometres: exact in float; chunk after chunk
    std::vector<std::uint32_t> body_vertex;   // of each: its index in its Body::vertices_um
    std::vector<std::array<std::uint16_t, 3>>
        triangles;                             // into the chunk's vertices; anticlockwise from outside
    std::vector<Eigen::Vector3f> grain_places; // of the vertices of textured chunks (trabeculae.hpp)
};

inline constexpr int mesh_chunk_triangles = 128;

// Sets the sphere around a chunk to the sphere around the box of its vertices.
void set_sphere(MeshChunk &chunk, const Eigen::Vector3f &low_um, const Eigen::Vector3f &high_um);

// Cuts one body into chunks of neighbouring triangles, and appends it to the meshes. `own` is the material of
// the body, and `parent` is the material around it; a parent of -1 is air. A body of its parent's material
// gets no texture, because it does not show. Spongy bone in cortical bone has the density that its material's
// name states.
void append_body(BodyMeshes &meshes, const Body &body, int own, int parent);

// Replaces the vertices of a body, which keep their places in the texture, by the same number of new
// vertices; the triangles keep their vertex indices.
void move_body(BodyMeshes &meshes, int body, std::span<const Eigen::Vector3i> vertices_um);

// Returns the present vertices of a body in the order of Body::vertices_um; a vertex that no triangle uses is
// returned as 0.
std::vector<Eigen::Vector3i> body_vertices_um(const BodyMeshes &meshes, int body);

} // namespace crn
