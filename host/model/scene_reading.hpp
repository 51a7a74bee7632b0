// Reads a scene file that `bake` wrote, in order to extract one part of its data.
#pragma once
#include "host/base/text.hpp"
#include "shared/scene/scene.h"
#include <string>
#include <vector>

namespace crn
{

// The callback `use` receives the checked scene, and the scene's bytes are released afterwards. Returns the
// result of `use`. If the path is empty or an error occurs, returns `{}`; after an error, `error` names the
// file and the byte.
template <typename Result, typename Use>
Result from_scene(const std::string &scene_path, std::string &error, Use use)
{
    error.clear();
    if (scene_path.empty()) return {};
    try {
        const std::vector<unsigned char> bytes = read_binary_file(scene_path);
        crn_scene scene;
        std::uint32_t where_byte = 0;
        const crn_scene_status status = crn_scene_open(bytes.data(), bytes.size(), &scene, &where_byte);
        if (status == CRN_SCENE_OK) return use(scene);
        error = scene_path + ": byte " + std::to_string(where_byte) + ": " + crn_scene_status_text(status);
    } catch (const FileError &fault) {
        error = fault.what();
    }
    return {};
}

} // namespace crn
