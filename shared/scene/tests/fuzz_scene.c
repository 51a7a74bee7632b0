/* This fuzz target opens arbitrary bytes as a scene. The fuzz target reads an accepted scene in the same way
 * as the core and the host do; if a guarantee is broken, the program ends. The fuzz target tries each input
 * unchanged and with corrected CRCs, so that the input also reaches the checks that follow the CRC checks. */
#include "shared/scene/tests/scene_sample.h"

#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);
size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity);

static void promise(bool kept)
{
    if (!kept) abort();
}

/* Checks that the refinement of bricks ends after at most two rows, and that every brick in the index exists.
 */
static void walk_entry(const crn_scene_lumen *lumen, uint32_t entry)
{
    for (int level = 0; entry >= 0x8000; level++) {
        uint32_t row = entry & 0x7fffu;
        promise(level < 2 && row < lumen->child_row_count);
        uint32_t next = 0;
        for (int i = 0; i < 8; i++) {
            uint32_t child = lumen->children[row * 8 + (uint32_t)i];
            promise(child >= 0x8000 || child < 2 || child - 2 < lumen->brick_count);
            if (child >= 0x8000) next = child;
        }
        if (next == 0) return;
        entry = next;
    }
    promise(entry < 2 || entry - 2 < lumen->brick_count);
}

static void walk_branch(const crn_scene *scene, uint32_t index, const uint8_t *end)
{
    crn_scene_branch_view branch = crn_scene_branch(scene, index);
    promise(strlen(branch.name) < CRN_SCENE_BRANCH_NAME_BYTES && branch.bed < CRN_SCENE_BED_COUNT);
    promise(branch.parent < (int32_t)index && (branch.parent == -1) == (index == 0));
    if (index > 0)
        promise(branch.parent_point < crn_scene_branch(scene, (uint32_t)branch.parent).point_count);
    promise(branch.point_count >= 2 &&
            branch.points + CRN_SCENE_TREE_POINT_BYTES * (size_t)branch.point_count <= end);
}

static void walk_small(const crn_scene *scene, uint32_t index, const uint8_t *end)
{
    crn_scene_branch_view vessel = crn_scene_small(scene, index);
    promise(strlen(vessel.name) < CRN_SCENE_BRANCH_NAME_BYTES && vessel.bed < CRN_SCENE_BED_COUNT);
    promise(vessel.parent < (int32_t)(scene->branch_count + index));
    promise(vessel.parent >= 0 || (vessel.flags & CRN_SCENE_BRANCH_IS_VEIN) != 0);
    promise((vessel.flags & CRN_SCENE_BRANCH_JOINS) == 0 ||
            (vessel.joins >= scene->branch_count && vessel.joins - scene->branch_count < scene->small_count));
    promise(vessel.point_count >= 2 &&
            vessel.points + CRN_SCENE_TREE_POINT_BYTES * (size_t)vessel.point_count <= end);
}

static void walk_lesion(const crn_scene *scene, uint32_t index, const uint8_t *end)
{
    crn_scene_lesion_view lesion = crn_scene_lesion(scene, index);
    promise(strlen(lesion.name) < CRN_SCENE_BRANCH_NAME_BYTES && lesion.branch < scene->branch_count);
    const uint32_t points = crn_scene_branch(scene, lesion.branch).point_count;
    promise(lesion.point_count >= 3 && lesion.first_point < points &&
            lesion.point_count <= points - lesion.first_point);
    promise(lesion.healthy_points + CRN_SCENE_TREE_POINT_BYTES * (size_t)lesion.point_count <= end);
}

/* Checks that every number of a lattice is within its range, so that the core's sums fit, and that the
 * lattice's boundary does not move. */
static void walk_motion(const crn_scene_motion *motion, size_t row, const uint8_t *end)
{
    const size_t nx = motion->node_count_xyz[0], ny = motion->node_count_xyz[1],
                 nz = motion->node_count_xyz[2];
    promise(nx >= 2 && ny >= 2 && nz >= 2);
    promise((const uint8_t *)(motion->rows + nx * ny * nz * 3 * row) <= end);
    for (size_t i = 0; i < nx * ny * nz * 3 * row; i++) {
        const size_t node = i / (3 * row), x = node % nx, y = node / nx % ny, z = node / nx / ny;
        const bool is_edge = x == 0 || y == 0 || z == 0 || x + 1 == nx || y + 1 == ny || z + 1 == nz;
        promise(motion->rows[i] <= CRN_SCENE_MOTION_VALUE_MAX &&
                motion->rows[i] >= -CRN_SCENE_MOTION_VALUE_MAX);
        promise(!is_edge || motion->rows[i] == 0);
    }
}

static void walk_plaque(const crn_scene *scene, uint32_t index, const uint8_t *end)
{
    const crn_scene_plaque_view plaque = crn_scene_plaque(scene, index);
    promise(plaque.station_count >= 3 && plaque.station_count <= CRN_SCENE_PLAQUE_STATION_MAX);
    promise(plaque.stations + CRN_SCENE_PLAQUE_STATION_BYTES * (size_t)plaque.station_count <= end);
    for (uint32_t i = 0; i < plaque.station_count; i++) {
        const uint8_t *station = plaque.stations + CRN_SCENE_PLAQUE_STATION_BYTES * (size_t)i;
        promise(crn_scene_i32(station + 28) > 0 &&
                crn_scene_i32(station + 12) >= crn_scene_i32(station + 28));
    }
}

static void walk(const crn_scene *scene, const uint8_t *end)
{
    promise(strlen(scene->name) < 64 && strlen(scene->source) < 192);
    const crn_scene_lumen *lumen = &scene->lumen;
    if (scene->kind == CRN_SCENE_KIND_SCENE) {
        size_t count =
            (size_t)lumen->brick_count_xyz[0] * lumen->brick_count_xyz[1] * lumen->brick_count_xyz[2];
        for (size_t i = 0; i < count; i++) walk_entry(lumen, lumen->index[i]);
        promise((const uint8_t *)lumen->samples + (size_t)lumen->brick_count * 1000 <= end);
        if (scene->has_motion) walk_motion(&scene->motion, CRN_SCENE_MOTION_ROW, end);
        if (scene->has_breath) walk_motion(&scene->breath, 1, end);
        for (uint32_t i = 0; i < scene->plaque_count; i++) walk_plaque(scene, i, end);
    }
    for (uint32_t i = 0; i < scene->body_count; i++) {
        crn_scene_body_view body = crn_scene_body(scene, i);
        promise(body.parent < (int32_t)scene->body_count && strlen(body.name) < 32 &&
                strlen(body.material) < 16);
        promise(body.triangles + 12 * (size_t)body.triangle_count <= end);
        for (size_t k = 0; k < 3 * (size_t)body.triangle_count; k++)
            promise(crn_scene_u32(body.triangles + 4 * k) < body.vertex_count);
        promise(!body.breath_um ||
                body.breath_um + CRN_SCENE_BODY_BREATH_BYTES * (size_t)body.vertex_count <= end);
    }
    for (uint32_t i = 0; i < scene->branch_count; i++) walk_branch(scene, i, end);
    for (uint32_t i = 0; i < scene->small_count; i++) walk_small(scene, i, end);
    for (uint32_t i = 0; i < scene->lesion_count; i++) walk_lesion(scene, i, end);
}

static void offer(const uint8_t *bytes, size_t size)
{
    crn_scene scene;
    uint32_t where = 0;
    crn_scene_status status = crn_scene_open(bytes, size, &scene, &where);
    promise(crn_scene_status_text(status)[0] != 0 && where <= size);
    if (status == CRN_SCENE_OK) walk(&scene, bytes + size);
}

/* Requirement: SR-20 */
int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    uint8_t *copy = malloc(size + 1); /* exact size, so that a read past the end is detected */
    if (copy == NULL) return 0;
    memcpy(copy, bytes, size);
    offer(copy, size);
    if (size >= 20) crn_scene_put_u32(copy + 16, (uint32_t)size);
    sample_seal(copy, size);
    offer(copy, size);
    free(copy);
    return 0;
}

size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity)
{
    if (index == 0) return sample_scene(bytes, capacity);
    if (index <= 2 && index > 0)
        return sample_body_file(bytes, capacity, index == 2 ? SAMPLE_TREE : SAMPLE_NO_TREE);
    if (index == 4) return sample_body_file(bytes, capacity, SAMPLE_LESIONS);
    if (index == 5 || index == 6) return sample_diseased_scene(bytes, capacity, index == 6);
    if (index == 7) return sample_body_file_of(bytes, capacity, SAMPLE_LESIONS, 1);
    if (index == 8) return sample_breathing_body(bytes, capacity);
    return index == 3 ? sample_moving_scene(bytes, capacity) : 0;
}
