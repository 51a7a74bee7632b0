// Depth sums of closed meshes: where a ray leaves a body its distance is added, where it enters it is subtracted.
// The sums are int32 in 1/1024 mm along the central axis, so their total does not depend on the order of triangles.
#pragma once
#include "host/model/bodies.hpp"
#include "host/xray/carm.hpp"
#include "host/xray/materials.hpp"
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace seld
{

// Bodies of one material inside one other share a channel: a sum is theirs, and is taken from the parent's material.
struct RasterChannel {
    int own = 0;     // material
    int parent = -1; // material, -1: air
};

// A few hundred neighbouring triangles with the vertices they use.
struct RasterChunk {
    std::uint32_t vertex_begin = 0, vertex_count = 0;
    std::uint32_t triangle_begin = 0, triangle_count = 0;
    int channel = 0;
    Eigen::Vector3f centre_um = Eigen::Vector3f::Zero();
    float radius_um = 0.0f;
};

struct RasterMeshes {
    std::vector<RasterChannel> channels;
    std::vector<RasterChunk> chunks;
    std::vector<Eigen::Vector3f> vertices_um;            // whole micrometres: exact in float
    std::vector<std::array<std::uint16_t, 3>> triangles; // into the chunk's vertices
};

inline constexpr int raster_chunk_triangles = 512;

// Adds one body, cut into chunks, to a channel.
void append_body(RasterMeshes &meshes, const Body &body, int channel);

// Adds the depth sums of one chunk to `sums`, the size*size picture of the chunk's channel.
void raster_chunk(const RasterMeshes &meshes, const RasterChunk &chunk, const View &view, std::int32_t *sums);

} // namespace seld
