/* This header describes the file of one measured case, which budget_make.c (on the PC) writes and
 * budget_image.c (on the Cortex-M7) reads. Both programs read and write the file as structs of 32-bit words,
 * little-endian. Both programs build the model by the functions of this header, so both measure and compute
 * the same case. */
#ifndef CRN_BUDGET_CASE_H
#define CRN_BUDGET_CASE_H

#include "firmware/core/core_state.h"

enum {
    BUDGET_MAGIC = 0x42444731,
    BUDGET_TICKS_MAX = 1000,
    BUDGET_NEAR_BYTES = 400 << 10, /* near memory, as in the port for the i.MX RT1062 */
};

/* After its header, the file has the lumen's index, child rows and samples (each padded to words), then the
 * state, and then one crn_input per tick. */
typedef struct budget_case {
    uint32_t magic;
    uint32_t ticks;
    uint32_t index_bytes, children_bytes, samples_bytes, state_bytes;
    uint32_t hash_lane[2]; /* after the last tick, as the PC computed it */
    int32_t lumen_origin_m_q30[3];
    uint32_t lumen_bricks_xyz[3], lumen_child_rows, lumen_bricks;
    uint32_t tool_count;
    crn_instrument tools[CRN_TOOL_MAX];
    crn_entry entry;
} budget_case;

static inline uint32_t budget_padded(uint32_t bytes)
{
    return (bytes + 3u) & ~3u;
}

/* Holds the addresses of the parts of a case that has been read into memory. */
static inline const uint8_t *budget_state(const budget_case *c)
{
    return (const uint8_t *)(c + 1) + budget_padded(c->index_bytes) + budget_padded(c->children_bytes) +
           budget_padded(c->samples_bytes);
}
static inline const crn_input *budget_inputs(const budget_case *c)
{
    return (const crn_input *)(const void *)(budget_state(c) + c->state_bytes);
}

/* Builds the model of a case; returns false when the core refuses it. `lumen` and the case's memory must
 * exist as long as the model is used. */
static inline bool budget_build(const budget_case *c, crn_lumen *lumen, crn_model *model)
{
    const uint8_t *field = (const uint8_t *)(c + 1);
    *lumen = (crn_lumen){
        .origin_m_q30 = {c->lumen_origin_m_q30[0], c->lumen_origin_m_q30[1], c->lumen_origin_m_q30[2]},
        .brick_count_xyz = {c->lumen_bricks_xyz[0], c->lumen_bricks_xyz[1], c->lumen_bricks_xyz[2]},
        .child_row_count = (uint16_t)c->lumen_child_rows,
        .brick_count = c->lumen_bricks,
        .index = (const uint16_t *)(const void *)field,
        .children = (const uint16_t *)(const void *)(field + budget_padded(c->index_bytes)),
        .samples = (const int8_t *)(field + budget_padded(c->index_bytes) + budget_padded(c->children_bytes)),
        .motion = NULL,
        .lesion_count = 0,
        .lesions = NULL,
        .walls = NULL,
        .near = NULL,
    };
    crn_build_place place;
    return c->magic == BUDGET_MAGIC && c->state_bytes == crn_state_bytes() &&
           crn_model_build(model, c->tools, c->tool_count, lumen, &c->entry, &place) == CRN_BUILD_OK;
}

#endif
