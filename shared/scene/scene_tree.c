/* Checking and reading the TREE section of a body file. */
#include "shared/scene/scene_check.h"

/* Fields of a branch, as bytes from its beginning. */
enum {
    PARENT_AT = 32,
    PARENT_POINT_AT = 36,
    FIRST_AT = 40,
    COUNT_AT = 44,
    BED_AT = 48,
    FLOW_AT = 52,
    ZERO_AT = 56
};

static const uint8_t *branch_at(const uint8_t *tree, uint32_t index)
{
    return tree + SELD_SCENE_TREE_HEADER_BYTES + (size_t)index * SELD_SCENE_BRANCH_BYTES;
}

seld_scene_branch_view seld_scene_branch(const seld_scene *scene, uint32_t index)
{
    const uint8_t *branch = branch_at(scene->tree, index);
    seld_scene_branch_view view;
    view.name = (const char *)branch;
    view.parent = seld_scene_i32(branch + PARENT_AT);
    view.parent_point = seld_scene_u32(branch + PARENT_POINT_AT);
    view.point_count = seld_scene_u32(branch + COUNT_AT);
    view.bed = (seld_scene_bed)seld_scene_u32(branch + BED_AT);
    view.flow_mm3_per_s = seld_scene_u32(branch + FLOW_AT);
    view.points = branch_at(scene->tree, scene->branch_count) +
                  (size_t)seld_scene_u32(branch + FIRST_AT) * SELD_SCENE_TREE_POINT_BYTES;
    return view;
}

seld_scene_status seld_scene_check_tree_point(seld_scene_check *check, size_t at, seld_scene_status fault)
{
    for (size_t k = 0; k < 3; k++) {
        int32_t coordinate = seld_scene_i32(check->bytes + at + 4 * k);
        if (coordinate > SELD_SCENE_BODY_REACH_um || coordinate < -SELD_SCENE_BODY_REACH_um)
            return seld_scene_fault_at(check, fault, at + 4 * k);
    }
    uint32_t radius = seld_scene_u32(check->bytes + at + 12);
    if (radius < SELD_SCENE_RADIUS_MIN_um || radius > SELD_SCENE_RADIUS_MAX_um)
        return seld_scene_fault_at(check, fault, at + 12);
    return SELD_SCENE_OK;
}

static seld_scene_status check_points(seld_scene_check *check, size_t where, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        size_t at = where + (size_t)i * SELD_SCENE_TREE_POINT_BYTES;
        const uint8_t *point = check->bytes + at, *before = point - SELD_SCENE_TREE_POINT_BYTES;
        seld_scene_status status = seld_scene_check_tree_point(check, at, SELD_SCENE_TREE_POINT);
        if (status != SELD_SCENE_OK) return status;
        bool has_moved = i == 0;
        for (size_t k = 0; k < 12; k += 4)
            has_moved = has_moved || seld_scene_i32(point + k) != seld_scene_i32(before + k);
        if (!has_moved) return seld_scene_fault_at(check, SELD_SCENE_TREE_POINT, at);
    }
    return SELD_SCENE_OK;
}

/* Parents come first, so that there is no circle, and points follow each other without a gap. */
static seld_scene_status check_branch(seld_scene_check *check, const uint8_t *tree, uint32_t index,
                                      uint32_t *points_before)
{
    const uint8_t *branch = branch_at(tree, index);
    size_t where = (size_t)(branch - check->bytes);
    seld_scene_status status = seld_scene_check_text(check, where, SELD_SCENE_BRANCH_NAME_BYTES);
    if (status != SELD_SCENE_OK) return status;
    int32_t parent = seld_scene_i32(branch + PARENT_AT);
    if (index == 0 ? parent != -1 : parent < 0 || (uint32_t)parent >= index)
        return seld_scene_fault_at(check, SELD_SCENE_TREE_BRANCH, where + PARENT_AT);
    uint32_t places = index == 0 ? 1 : seld_scene_u32(branch_at(tree, (uint32_t)parent) + COUNT_AT);
    if (seld_scene_u32(branch + PARENT_POINT_AT) >= places)
        return seld_scene_fault_at(check, SELD_SCENE_TREE_BRANCH, where + PARENT_POINT_AT);
    uint32_t count = seld_scene_u32(branch + COUNT_AT);
    if (seld_scene_u32(branch + FIRST_AT) != *points_before)
        return seld_scene_fault_at(check, SELD_SCENE_TREE_SIZE, where + FIRST_AT);
    if (count < 2 || count > SELD_SCENE_TREE_POINT_MAX - *points_before)
        return seld_scene_fault_at(check, SELD_SCENE_TREE_SIZE, where + COUNT_AT);
    *points_before += count;
    if (seld_scene_u32(branch + BED_AT) >= SELD_SCENE_BED_COUNT)
        return seld_scene_fault_at(check, SELD_SCENE_TREE_BRANCH, where + BED_AT);
    if (seld_scene_u32(branch + FLOW_AT) > SELD_SCENE_BRANCH_FLOW_MAX_mm3_per_s)
        return seld_scene_fault_at(check, SELD_SCENE_TREE_BRANCH, where + FLOW_AT);
    for (size_t k = 0; k < 8; k++) {
        if (branch[ZERO_AT + k] != 0)
            return seld_scene_fault_at(check, SELD_SCENE_RESERVED, where + ZERO_AT + k);
    }
    return SELD_SCENE_OK;
}

seld_scene_status seld_scene_check_tree(seld_scene_check *check, seld_scene_span span, uint32_t *branch_count)
{
    if (span.size < SELD_SCENE_TREE_HEADER_BYTES)
        return seld_scene_fault_at(check, SELD_SCENE_SECTION_SIZE, span.offset);
    const uint8_t *tree = check->bytes + span.offset;
    uint32_t branches = seld_scene_u32(tree), points = seld_scene_u32(tree + 4);
    if (branches == 0 || branches > SELD_SCENE_BRANCH_MAX)
        return seld_scene_fault_at(check, SELD_SCENE_TREE_SIZE, span.offset);
    if (points > SELD_SCENE_TREE_POINT_MAX)
        return seld_scene_fault_at(check, SELD_SCENE_TREE_SIZE, span.offset + 4);
    if (seld_scene_u32(tree + 8) != 0 || seld_scene_u32(tree + 12) != 0)
        return seld_scene_fault_at(check, SELD_SCENE_RESERVED, span.offset + 8);
    if (span.size != SELD_SCENE_TREE_HEADER_BYTES + (uint64_t)branches * SELD_SCENE_BRANCH_BYTES +
                         (uint64_t)points * SELD_SCENE_TREE_POINT_BYTES)
        return seld_scene_fault_at(check, SELD_SCENE_SECTION_SIZE, span.offset);
    uint32_t points_before = 0;
    for (uint32_t i = 0; i < branches; i++) {
        seld_scene_status status = check_branch(check, tree, i, &points_before);
        if (status != SELD_SCENE_OK) return status;
    }
    if (points_before != points) return seld_scene_fault_at(check, SELD_SCENE_TREE_SIZE, span.offset + 4);
    size_t at = (size_t)(branch_at(tree, branches) - check->bytes);
    for (uint32_t i = 0; i < branches; i++) {
        uint32_t count = seld_scene_u32(branch_at(tree, i) + COUNT_AT);
        seld_scene_status status = check_points(check, at, count);
        if (status != SELD_SCENE_OK) return status;
        at += (size_t)count * SELD_SCENE_TREE_POINT_BYTES;
    }
    *branch_count = branches;
    return SELD_SCENE_OK;
}
