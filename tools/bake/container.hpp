// Baked things as bytes of the scene container, and files that are whole or not there.
#pragma once
#include "host/model/vessel_tree.hpp"
#include "tools/bake/field.hpp"
#include "tools/bake/motion.hpp"

namespace crn::bake
{

using Bytes = std::vector<std::uint8_t>;

struct BakedBody {
    std::string name, material;
    int parent = -1;
    Mesh mesh;
    bool moves = false; // with the lumen
};

// Both are opened by shared/scene before they are returned; a refusal is a Fault. `motion` nullptr: the lumen
// stands still; `tree` nullptr: no lesion of it gives way, else as it lies in the field.
Bytes scene_bytes(const SceneText &text, const Eigen::Vector3d &entry_mm, const Eigen::Vector3d &direction,
                  const Field &field, const Motion *motion = nullptr, const VesselTree *tree = nullptr);
// `scene`: the bytes of the scene they belong to, which they name; empty: of none.
Bytes bodies_bytes(const SceneText &text, const std::vector<BakedBody> &bodies, const VesselTree &tree,
                   const Bytes &scene = {});

// Written beside the target and renamed, so that an interrupt or a full disk leaves the old file.
void write_whole(const std::filesystem::path &file, const Bytes &bytes);
// A scene and its bodies: both or neither.
void write_both(const std::filesystem::path &scene_file, const Bytes &scene,
                const std::filesystem::path &bodies_file, const Bytes &bodies);

} // namespace crn::bake
