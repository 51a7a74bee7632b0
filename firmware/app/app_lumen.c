/* This file turns a scene's bytes into the form in which the core reads the lumen. The scene's validator
 * checks every byte before the core uses any of them. */
#include "firmware/app/app_internal.h"
#include "shared/scene/scene.h"

_Static_assert((int)CRN_SCENE_MOTION_ROW == (int)CRN_MOTION_ROW &&
                   (int)CRN_SCENE_MOTION_KEYFRAMES == (int)CRN_MOTION_KEYFRAMES &&
                   (int)CRN_SCENE_MOTION_VALUE_MAX == (int)CRN_MOTION_COEFFICIENT_MAX &&
                   (int)CRN_SCENE_MOTION_SPACING_LOG2_MIN == (int)CRN_MOTION_SPACING_LOG2_MIN &&
                   (int)CRN_SCENE_MOTION_SPACING_LOG2_MAX == (int)CRN_MOTION_SPACING_LOG2_MAX,
               "scene and core agree about the lattice of a moving vessel");

static crn_lattice lattice_from(const crn_scene_motion *scene)
{
    return (crn_lattice){
        .origin_m_q30 = {scene->origin_m_q30[0], scene->origin_m_q30[1], scene->origin_m_q30[2]},
        .count_xyz = {scene->node_count_xyz[0], scene->node_count_xyz[1], scene->node_count_xyz[2]},
        .spacing_log2_q30 = scene->spacing_log2_q30,
    };
}

static crn_motion motion_from(const crn_scene *scene)
{
    return (crn_motion){
        .beat = lattice_from(&scene->motion),
        .rows = scene->motion.rows,
        .breath = lattice_from(&scene->breath),
        .inhaled = scene->has_breath ? scene->breath.rows : NULL,
    };
}

_Static_assert((int)CRN_SCENE_PLAQUE_MAX == (int)CRN_LESION_MAX &&
                   (int)CRN_SCENE_PLAQUE_STATION_MAX == (int)CRN_LESION_STATION_MAX &&
                   (int)CRN_SCENE_PLAQUE_STATION_BYTES == (int)sizeof(crn_lesion_station),
               "scene and core agree about lesions that give way");

/* The stations stay in place. The words of a scene must have the byte order of this machine, which the code
 * checks, and begin at an address that is a multiple of 16. */
static crn_lesion lesion_from(const crn_scene_plaque_view *plaque)
{
    crn_lesion lesion = {
        .stretch_q28 = plaque->stretch_q28,
        .spacing_log2_q30 = plaque->spacing_log2_q30,
        .station_count = plaque->station_count,
        .yield_Pa = plaque->yield_Pa,
        .full_Pa = plaque->full_Pa,
        .recoil_q30 = plaque->recoil_q30,
        .pace_q30 = plaque->pace_q30,
        .stations = (const crn_lesion_station *)(const void *)plaque->stations,
    };
    for (int k = 0; k < 3; k++) {
        lesion.low_m_q30[k] = plaque->low_m_q30[k];
        lesion.high_m_q30[k] = plaque->high_m_q30[k];
        lesion.chord_q30[k] = plaque->chord_q30[k];
    }
    return lesion;
}

_Static_assert((int)CRN_SCENE_WALL_LAW_MAX == (int)CRN_WALL_LAW_MAX &&
                   (int)CRN_SCENE_WALL_LAW_BYTES == (int)sizeof(crn_wall_law),
               "scene and core agree about walls that give way");

/* The laws stay in place, as the stations of lesions do. */
static crn_walls walls_from(const crn_scene *scene)
{
    return (crn_walls){
        .law_count = scene->wall_law_count,
        .laws = (const crn_wall_law *)(const void *)scene->wall_laws,
        .law_of_brick = scene->wall_law_of_brick,
    };
}

uint32_t crn_app_lumen_open(const uint8_t *bytes, uint32_t byte_count, crn_opened_scene *opened)
{
    crn_scene scene;
    crn_scene_status status = crn_scene_open(bytes, byte_count, &scene, NULL);
    if (status != CRN_SCENE_OK) return status;
    if (scene.kind != CRN_SCENE_KIND_SCENE) return CRN_SCENE_KIND;
    opened->lumen = (crn_lumen){
        .origin_m_q30 = {scene.lumen.origin_m_q30[0], scene.lumen.origin_m_q30[1],
                         scene.lumen.origin_m_q30[2]},
        .brick_count_xyz = {scene.lumen.brick_count_xyz[0], scene.lumen.brick_count_xyz[1],
                            scene.lumen.brick_count_xyz[2]},
        .child_row_count = scene.lumen.child_row_count,
        .brick_count = scene.lumen.brick_count,
        .index = scene.lumen.index,
        .children = scene.lumen.children,
        .samples = scene.lumen.samples,
        .motion = scene.has_motion ? &opened->motion : NULL,
        .lesion_count = scene.plaque_count,
        .lesions = opened->lesions,
        .walls = scene.wall_law_count > 0 ? &opened->walls : NULL,
    };
    for (uint32_t i = 0; i < scene.plaque_count; i++) {
        const crn_scene_plaque_view plaque = crn_scene_plaque(&scene, i);
        opened->lesions[i] = lesion_from(&plaque);
    }
    opened->motion = motion_from(&scene);
    opened->walls = walls_from(&scene);
    return CRN_SCENE_OK;
}
