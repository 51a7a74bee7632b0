#include "host/model/scene_anatomy.hpp"
#include <filesystem>
#include <stdexcept>

namespace crn
{

SceneAnatomy read_scene_anatomy(const std::string &scene_path, const std::string &bodies_path)
{
    SceneAnatomy anatomy;
    std::string error;
    if (!bodies_path.empty() && !read_bodies_of(scene_path, bodies_path, anatomy.bodies, error))
        throw std::runtime_error(error);
    anatomy.motion = read_motion(scene_path, error);
    if (!error.empty()) throw std::runtime_error(error);
    anatomy.stations = read_lesion_stations(scene_path, error);
    if (!error.empty()) throw std::runtime_error(error);
    return anatomy;
}

std::string bodies_beside(const std::string &scene)
{
    if (scene.empty()) return "";
    const std::filesystem::path path = std::filesystem::path(scene).replace_extension(".bodies");
    std::error_code ignored;
    return std::filesystem::exists(path, ignored) ? path.string() : "";
}

} // namespace crn
