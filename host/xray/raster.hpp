// Depth sums of closed meshes: where a ray leaves a body its distance is added, where it enters it is subtracted.
// The sums are int32 in 1/1024 mm along the central axis, so their total does not depend on the order of triangles.
#pragma once
#include "host/xray/carm.hpp"
#include "host/xray/meshes.hpp"

namespace seld
{

// Adds the depth sums of one chunk to `sums`, the size*size picture of the chunk's channel.
void raster_chunk(const BodyMeshes &meshes, const MeshChunk &chunk, const View &view, std::int32_t *sums);

} // namespace seld
