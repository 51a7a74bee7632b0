// What is known of a patient besides the lumen that the core has: bodies with their tree of vessels, how they
// move, and which lesions give way. One reader for pictures, contrast medium, stents and surfaces.
#pragma once
#include "host/model/bodies.hpp"
#include "host/model/lesion_opening.hpp"
#include "host/model/motion.hpp"
#include <optional>
#include <string>
#include <vector>

namespace crn
{

struct SceneAnatomy {
    Bodies bodies;
    std::optional<Motion> motion; // nothing: it stands still
    std::vector<LesionStations> stations;

    const Motion *motion_or_null() const { return motion ? &*motion : nullptr; }
};

// Empty paths: no bodies; nothing moves. Throws std::runtime_error, also for bodies that were not baked with
// this scene.
SceneAnatomy read_scene_anatomy(const std::string &scene_path, const std::string &bodies_path);

} // namespace crn
