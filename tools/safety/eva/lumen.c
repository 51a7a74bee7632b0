/* Samples the lumen (firmware/core/lumen.c) at every point, in scenes that shared/scene/scene_lumen.c
 * accepts: the largest and the smallest, with any coefficients, any origin and any contents of the index. A
 * sample reads at most three entries of the index, one of each rank. So it suffices to look at scenes whose
 * entries of one rank are of one kind: either bricks and marks, or references to rows of the next rank and
 * marks. */
#include "firmware/core/lumen.h"
#include "tools/safety/eva/any.h"

enum {
    MOST_LINES = 512, /* CRN_SCENE_LATTICE_MAX */
    MOST_ROWS = 0x8000,
    FEW_ROWS = 16, /* of the first rank where the second is large */
    MOST_BRICKS = 0x7ffe,
    BRICK_LOG2_Q30 = CRN_LUMEN_VOXEL_LOG2_Q30 + 3,
    OCTANTS = 8,
};

/* What a scene consists of. Rows of the first rank come first (scene_lumen.c). */
typedef struct eva_scene {
    uint32_t lines;            /* along each axis */
    uint32_t first_rank, rows; /* of children */
    uint32_t bricks;
    uint16_t *index, *children;
    int8_t *samples;
} eva_scene;

static uint16_t most_index[(size_t)MOST_LINES * MOST_LINES * MOST_LINES];
static uint16_t most_children[(size_t)MOST_ROWS * OCTANTS];
static int8_t most_samples[(size_t)MOST_BRICKS * CRN_LUMEN_BRICK_SAMPLES];
static uint16_t least_index[1], least_children[2 * OCTANTS];
static int8_t least_samples[CRN_LUMEN_BRICK_SAMPLES];

/* Sets entries to values from `low` to `high`. Where there are many, the analysis also keeps what they were,
 * here 0 (OUTSIDE). */
static void fill(uint16_t *entries, uint32_t count, uint32_t low, uint32_t high)
{
    /*@ loop unroll 128; */
    for (uint32_t i = 0; i < count; i++) entries[i] = (uint16_t)any_from(low, high);
}

/* Makes the entries of one rank refer to the rows first .. end - 1, or to bricks and marks. */
static void fill_rank(uint16_t *entries, uint32_t count, const eva_scene *scene, uint32_t first, uint32_t end)
{
    if (end > first) {
        fill(entries, count, CRN_LUMEN_ENTRY_REFINED + first, CRN_LUMEN_ENTRY_REFINED + end - 1);
    } else {
        fill(entries, count, 0, CRN_LUMEN_ENTRY_FIRST_BRICK + scene->bricks - 1);
    }
}

static void every_sample(const eva_scene *scene)
{
    const uint32_t most_origin = (1u << 31) - (scene->lines << BRICK_LOG2_Q30);
    crn_lumen lumen = {.brick_count_xyz = {scene->lines, scene->lines, scene->lines},
                       .child_row_count = (uint16_t)scene->rows,
                       .brick_count = scene->bricks,
                       .index = scene->index,
                       .children = scene->children,
                       .samples = scene->samples};
    for (int k = 0; k < 3; k++) lumen.origin_m_q30[k] = Frama_C_interval(INT32_MIN, (int32_t)most_origin);
    const crn_vec3 point = crn_vec3_make(any_i32(), any_i32(), any_i32());
    crn_lumen_voxel last = {any_u32()};
    crn_lumen_distance(&lumen, &point);
    crn_lumen_contact(&lumen, &point);
    crn_lumen_distance_unless_far(&lumen, &point, any_i32(), &last);
}

/* `ranks` is the number of refinements that lead to a brick: 0, 1 or 2. */
static void every_scene(const eva_scene *scene, uint32_t ranks)
{
    const uint32_t entries = scene->lines * scene->lines * scene->lines, first = scene->first_rank * OCTANTS,
                   second = scene->rows * OCTANTS - first;
    Frama_C_make_unknown((char *)scene->samples, scene->bricks * CRN_LUMEN_BRICK_SAMPLES);
    fill_rank(scene->index, entries, scene, 0, ranks > 0 ? scene->first_rank : 0);
    fill_rank(scene->children, first, scene, scene->first_rank, ranks > 1 ? scene->rows : 0);
    fill_rank(scene->children + first, second, scene, 0, 0);
    every_sample(scene);
}

void eva_main(void)
{
    const eva_scene wide = {MOST_LINES, MOST_ROWS,     MOST_ROWS,   MOST_BRICKS,
                            most_index, most_children, most_samples};
    const eva_scene deep = {MOST_LINES, FEW_ROWS,      MOST_ROWS,   MOST_BRICKS,
                            most_index, most_children, most_samples};
    const eva_scene least = {1, 1, 2, 1, least_index, least_children, least_samples};
    switch (any_from(0, 5)) {
    case 0:
        every_scene(&wide, 0);
        break;
    case 1:
        every_scene(&wide, 1);
        break;
    case 2:
        every_scene(&deep, 2);
        break;
    case 3:
        every_scene(&least, 0);
        break;
    case 4:
        every_scene(&least, 1);
        break;
    default:
        every_scene(&least, 2);
        break;
    }
}
