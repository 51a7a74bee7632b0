// Makes the folder of a scene from the meshes of a person's own vessels: lumen, tree of vessels, entry,
// bodies, the scene's text with every choice, the baked scene, and a session that begins in it.
#pragma once
#include "tools/patient/entry.hpp"
#include "tools/patient/union.hpp"

#include <functional>

namespace crn::patient
{

struct SceneWish {
    PartsWish parts;
    UnionWish lumen;
    std::string name = "Own vessels";
    std::optional<Eigen::Vector3d> entry_mm; // the end nearest to it; empty: found
    std::string names = "auto";              // "aorta", "parts", "numbers"
    double shortest_mm = 5;                  // branch that is kept
    // The structure at a place of the scene, as a label map names it; it takes the place of parts for the
    // names of branches. An empty name gives no vote.
    std::function<std::string(const Eigen::Vector3d &)> structure_at;
    std::vector<std::string> bodies; // "MATERIAL:FILE"
    bool has_bodies = true;          // tissue around the vessels, and blood
    std::filesystem::path folder;
};

// Makes lumen and tree of the parts, and the scene's folder. Throws Fault, and leaves no scene, if that
// cannot be done. The choices that were made so far are in `choices`.
void make_scene_folder(const std::vector<Part> &parts, const Frame &frame, const SceneWish &wish,
                       Choices &choices, bake::Progress &progress);

} // namespace crn::patient
