/* Scene bytes -> the core's view of the lumen. The validator checks every byte before the core sees one.
 * Called by: app_setup.c. */
#include "firmware/app/app_internal.h"
#include "shared/scene/scene.h"

_Static_assert((int)SELD_SCENE_MOTION_ROW == (int)SELD_MOTION_ROW &&
                   (int)SELD_SCENE_MOTION_KEYFRAMES == (int)SELD_MOTION_KEYFRAMES &&
                   (int)SELD_SCENE_MOTION_VALUE_MAX == (int)SELD_MOTION_COEFFICIENT_MAX &&
                   (int)SELD_SCENE_MOTION_SPACING_LOG2_MIN == (int)SELD_MOTION_SPACING_LOG2_MIN &&
                   (int)SELD_SCENE_MOTION_SPACING_LOG2_MAX == (int)SELD_MOTION_SPACING_LOG2_MAX,
               "scene and core agree about the lattice of a moving vessel");

static seld_motion motion_from(const seld_scene_motion *scene)
{
    return (seld_motion){
        .origin_m_q30 = {scene->origin_m_q30[0], scene->origin_m_q30[1], scene->origin_m_q30[2]},
        .count_xyz = {scene->node_count_xyz[0], scene->node_count_xyz[1], scene->node_count_xyz[2]},
        .spacing_log2_q30 = scene->spacing_log2_q30,
        .rows = scene->rows,
    };
}

uint32_t seld_app_lumen_open(const uint8_t *bytes, uint32_t byte_count, seld_lumen *lumen,
                             seld_motion *motion)
{
    seld_scene scene;
    seld_scene_status status = seld_scene_open(bytes, byte_count, &scene, NULL);
    if (status != SELD_SCENE_OK) return status;
    if (scene.kind != SELD_SCENE_KIND_SCENE) return SELD_SCENE_KIND;
    *lumen = (seld_lumen){
        .origin_m_q30 = {scene.lumen.origin_m_q30[0], scene.lumen.origin_m_q30[1],
                         scene.lumen.origin_m_q30[2]},
        .brick_count_xyz = {scene.lumen.brick_count_xyz[0], scene.lumen.brick_count_xyz[1],
                            scene.lumen.brick_count_xyz[2]},
        .child_row_count = scene.lumen.child_row_count,
        .brick_count = scene.lumen.brick_count,
        .index = scene.lumen.index,
        .children = scene.lumen.children,
        .samples = scene.lumen.samples,
        .motion = scene.has_motion ? motion : NULL,
    };
    *motion = motion_from(&scene.motion);
    return SELD_SCENE_OK;
}
