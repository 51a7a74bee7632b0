// Packs the data that `bake` has made into the bytes of the scene container, and writes files completely or
// not at all.
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
    std::vector<Eigen::Vector3d> inhaled_mm =
        {};                     // the vertices after a full breath; empty: breath does not move it
    bool is_trabecular = false; // has the texture of trabeculae in X-ray pictures
};

// The functions below check the bytes that they return with the scene reader of shared/scene, and throw Fault
// if it rejects them. `motion` is nullptr when the lumen does not move. `tree` holds the lesions; it is
// nullptr when the scene has no lesion that a balloon can open. `start_um` is the start length, 0 if the
// scene states none.
Bytes scene_bytes(const SceneText &text, const Eigen::Vector3d &entry_mm, const Eigen::Vector3d &direction,
                  const Field &field, const Motion *motion = nullptr, const VesselTree *tree = nullptr,
                  std::uint32_t start_um = 0);
// `scene` holds the bytes of the scene to which the bodies belong; the body file records their hash. The
// parameter `scene` is empty when the bodies belong to no scene.
Bytes bodies_bytes(const SceneText &text, const std::vector<BakedBody> &bodies, const VesselTree &tree,
                   const Bytes &scene = {});

// The new file is written beside the old file and then renamed, so an interrupted run or a full disk leaves
// the old file intact.
void write_whole(const std::filesystem::path &file, const Bytes &bytes);
// Writes a scene file and its body file; either both files are replaced or neither.
void write_both(const std::filesystem::path &scene_file, const Bytes &scene,
                const std::filesystem::path &bodies_file, const Bytes &bodies);

} // namespace crn::bake
