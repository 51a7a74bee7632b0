#include "host/session/scene_file.hpp"
#include "host/base/text.hpp"
#include "host/model/units.hpp"
#include "shared/scene/scene.h"
#include "shared/wire/wire_frame.h"

namespace crn
{

namespace
{

SceneFile free_space()
{
    SceneFile scene;
    scene.name = "free space";
    scene.entry.direction_y_q30 = units::unit_to_q30(1.0);
    return scene;
}

} // namespace

SceneFile read_scene(const std::string &path)
{
    if (path.empty()) return free_space();
    SceneFile file;
    file.path = path;
    file.bytes = read_binary_file(path);
    crn_scene scene;
    std::uint32_t where_byte = 0;
    crn_scene_status status = crn_scene_open(file.bytes.data(), file.bytes.size(), &scene, &where_byte);
    if (status == CRN_SCENE_OK && scene.kind != CRN_SCENE_KIND_SCENE) status = CRN_SCENE_KIND;
    if (status != CRN_SCENE_OK) {
        throw FileError(path, 0, 0,
                        std::string("is no usable scene: ") + crn_scene_status_text(status) + " (at byte " +
                            std::to_string(where_byte) + ")");
    }
    file.crc32 = crn_wire_crc32(0, file.bytes.data(), file.bytes.size());
    file.name = scene.name;
    if (scene.entry_start_um > 0) file.start_um = scene.entry_start_um;
    file.entry.position_x_m_q30 = scene.entry_position_m_q30[0];
    file.entry.position_y_m_q30 = scene.entry_position_m_q30[1];
    file.entry.position_z_m_q30 = scene.entry_position_m_q30[2];
    file.entry.direction_x_q30 = scene.entry_direction_q30[0];
    file.entry.direction_y_q30 = scene.entry_direction_q30[1];
    file.entry.direction_z_q30 = scene.entry_direction_q30[2];
    return file;
}

} // namespace crn
