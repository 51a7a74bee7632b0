// Holds a scene of the API: the baked scene, its bodies and its vessels. The scene does not change, so worlds
// and renderers of any thread share it.
#pragma once
#include "host/library/handles.hpp"
#include "host/model/scene_anatomy.hpp"
#include "host/script/tip_places.hpp"
#include "host/session/scene_file.hpp"
#include "host/xray/xray.hpp"
#include <mutex>
#include <vector>

namespace crn::library
{

class Scene
{
  public:
    // Throws Refused. If `bodies_path` is empty, the file beside the scene is used.
    Scene(const std::string &scene_path, const std::string &bodies_path);

    const SceneFile &file() const { return file_; }
    const SceneAnatomy &anatomy() const { return anatomy_; }
    const std::string &bodies_path() const { return bodies_path_; }
    const TipPlaces &tips() const { return tips_; }
    // The first call of this function makes the meshes for pictures, because many worlds need none.
    const XrayScene &xray() const;
    void describe(cournand_scene_info &info) const;
    void describe(std::uint32_t vessel, cournand_vessel &description) const;

  private:
    void collect_points();

    std::string bodies_path_;
    SceneFile file_;
    SceneAnatomy anatomy_;
    TipPlaces tips_;
    std::vector<std::vector<float>> points_m_; // of each vessel, rows of x, y, z, radius
    mutable std::once_flag made_xray_;
    mutable XrayScene xray_;
};

template <> struct HandleOf<cournand_scene> {
    using Object = Scene;
    static constexpr HandleKind kind = HandleKind::scene;
    static constexpr char name[] = "scene";
};

} // namespace crn::library
