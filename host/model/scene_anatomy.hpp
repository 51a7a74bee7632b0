// Reads the anatomy of a patient: bodies with their tree of vessels, their motion, and the lesions that a
// balloon can open. The core itself reads the lumen. The code for pictures, contrast medium, stents and
// surfaces uses this reader.
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

// If the paths are empty, the result has no bodies and no motion. Throws std::runtime_error if a file cannot
// be read, or if the bodies were not baked together with this scene.
SceneAnatomy read_scene_anatomy(const std::string &scene_path, const std::string &bodies_path);

// Returns the path of the bodies that belong to a scene: for "x.scene" it is "x.bodies". If the file of
// bodies does not exist, the returned path is empty.
std::string bodies_beside(const std::string &scene);

} // namespace crn
