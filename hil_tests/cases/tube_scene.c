#include "hil_tests/cases/tube_scene.h"
#include "firmware/tests/reference/tube_lumen.h"
#include "shared/scene/scene_write.h"

#include <stdlib.h>
#include <string.h>

/* The LUMEN section of docs/scene.md. The lattice is refined at most once, so every row of child bricks
 * belongs to a brick of the coarse lattice. */
static uint8_t *lumen_section(const crn_lumen *lumen, size_t *bytes)
{
    const uint32_t *n = lumen->brick_count_xyz;
    const size_t entries = (size_t)n[0] * n[1] * n[2], rows = lumen->child_row_count,
                 samples = (size_t)lumen->brick_count * CRN_LUMEN_BRICK_SAMPLES;
    *bytes = 32 + 2 * (entries + 8 * rows) + samples;
    uint8_t *section = calloc(1, *bytes);
    if (section == NULL) abort();
    for (int k = 0; k < 3; k++) {
        crn_scene_put_u32(section + 4 * k, (uint32_t)lumen->origin_m_q30[k]);
        crn_scene_put_u16(section + 12 + 2 * k, (uint16_t)n[k]);
    }
    crn_scene_put_u16(section + 18, (uint16_t)rows);
    crn_scene_put_u32(section + 20, lumen->brick_count);
    crn_scene_put_u16(section + 24, (uint16_t)rows);
    for (size_t i = 0; i < entries; i++) crn_scene_put_u16(section + 32 + 2 * i, lumen->index[i]);
    for (size_t i = 0; i < 8 * rows; i++)
        crn_scene_put_u16(section + 32 + 2 * (entries + i), lumen->children[i]);
    memcpy(section + 32 + 2 * (entries + 8 * rows), lumen->samples, samples);
    return section;
}

size_t hil_scene_of(const hil_piece *pieces, uint32_t count, double radius_m, uint32_t level, uint8_t *file,
                    size_t capacity)
{
    reference_piece path[HIL_PIECES_MAX];
    for (uint32_t i = 0; i < count; i++)
        path[i] = (reference_piece){pieces[i].length_m, pieces[i].angle_rad, 0.0};
    reference_tube *tube = reference_tube_make(path, count, radius_m, level);
    size_t lumen_bytes;
    uint8_t *lumen = lumen_section(&tube->lumen, &lumen_bytes);
    uint8_t meta[CRN_SCENE_META_BYTES] = "tube", entry[CRN_SCENE_ENTRY_BYTES] = {0};
    crn_scene_put_u32(entry + 12, 1u << 30); /* along +x */
    const crn_scene_part parts[3] = {{CRN_SCENE_META, meta, sizeof meta},
                                     {CRN_SCENE_ENTRY, entry, sizeof entry},
                                     {CRN_SCENE_LUMEN, lumen, lumen_bytes}};
    size_t bytes = crn_scene_write(CRN_SCENE_KIND_SCENE, parts, 3, file, capacity);
    free(lumen);
    reference_tube_free(tube);
    return bytes;
}

size_t hil_tube_scene(uint8_t *file, size_t capacity)
{
    const hil_piece path[3] = {{0.06, 0.0}, {0.05, 1.0}, {0.15, 0.0}};
    return hil_scene_of(path, 3, 0.002, 0, file, capacity);
}
