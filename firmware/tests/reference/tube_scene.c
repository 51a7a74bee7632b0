/* This file writes the sections of a scene from a tube's lumen (docs/scene.md). */
#include "firmware/tests/reference/tube_scene.h"
#include "shared/scene/scene_write.h"

#include <stdlib.h>
#include <string.h>

/* The section LUMEN: header, coarse index, child rows, bricks. The rows that refine coarse bricks come first.
 */
static size_t write_lumen(const crn_lumen *lumen, uint8_t *section, size_t capacity)
{
    const uint32_t *n = lumen->brick_count_xyz;
    const size_t entries = (size_t)n[0] * n[1] * n[2],
                 samples = (size_t)lumen->brick_count * CRN_LUMEN_BRICK_SAMPLES;
    if (lumen->child_row_count != 0 || 32 + 2 * entries + samples > capacity) return 0;
    memset(section, 0, 32);
    for (int k = 0; k < 3; k++) {
        crn_scene_put_u32(section + 4 * k, (uint32_t)lumen->origin_m_q30[k]);
        crn_scene_put_u16(section + 12 + 2 * k, (uint16_t)n[k]);
    }
    crn_scene_put_u32(section + 20, lumen->brick_count);
    for (size_t i = 0; i < entries; i++) crn_scene_put_u16(section + 32 + 2 * i, lumen->index[i]);
    memcpy(section + 32 + 2 * entries, lumen->samples, samples);
    return 32 + 2 * entries + samples;
}

size_t reference_tube_scene(const reference_tube *tube, uint8_t *file, size_t capacity)
{
    uint8_t meta[CRN_SCENE_META_BYTES] = "tube", entry[CRN_SCENE_ENTRY_BYTES] = {0};
    crn_scene_put_u32(entry + 12, 1u << 30);
    uint8_t *section = malloc(capacity);
    const size_t lumen_bytes = section == NULL ? 0 : write_lumen(&tube->lumen, section, capacity);
    const crn_scene_part parts[3] = {{CRN_SCENE_META, meta, sizeof meta},
                                     {CRN_SCENE_ENTRY, entry, sizeof entry},
                                     {CRN_SCENE_LUMEN, section, lumen_bytes}};
    const size_t bytes =
        lumen_bytes == 0 ? 0 : crn_scene_write(CRN_SCENE_KIND_SCENE, parts, 3, file, capacity);
    free(section);
    return bytes;
}
