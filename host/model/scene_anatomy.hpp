// Reads the anatomy of a patient, except the lumen, which the core has: bodies with their tree of vessels,
// their motion, and the lesions that yield. Pictures, contrast medium, stents and surfaces all use this
// reader.
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
    std::optional<Motion> motion; // empty: nothing moves
    std::vector<LesionStations> stations;

    const Motion *motion_or_null() const { return motion ? &*motion : nullptr; }
};

// If the paths are empty, there are no bodies and no motion. Throws std::runtime_error, also for bodies that
// were not baked with this scene.
SceneAnatomy read_scene_anatomy(const std::string &scene_path, const std::string &bodies_path);

} // namespace crn
