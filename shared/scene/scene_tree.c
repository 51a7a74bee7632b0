/* This file checks the TREE section of a body file and gives access to the vessel tree. */
#include "shared/scene/scene_check.h"

/* Gives the fields of a branch as byte offsets from the branch's beginning. */
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
    return tree + CRN_SCENE_TREE_HEADER_BYTES + (size_t)index * CRN_SCENE_BRANCH_BYTES;
}

crn_scene_branch_view crn_scene_branch(const crn_scene *scene, uint32_t index)
{
    const uint8_t *branch = branch_at(scene->tree, index);
    crn_scene_branch_view view;
    view.name = (const char *)branch;
    view.parent = crn_scene_i32(branch + PARENT_AT);
    view.parent_point = crn_scene_u32(branch + PARENT_POINT_AT);
    view.point_count = crn_scene_u32(branch + COUNT_AT);
    view.bed = (crn_scene_bed)crn_scene_u32(branch + BED_AT);
    view.flow_mm3_per_s = crn_scene_u32(branch + FLOW_AT);
    view.points = branch_at(scene->tree, scene->branch_count) +
                  (size_t)crn_scene_u32(branch + FIRST_AT) * CRN_SCENE_TREE_POINT_BYTES;
    return view;
}

crn_scene_status crn_scene_check_tree_point(crn_scene_check *check, size_t at, crn_scene_status fault)
{
    for (size_t k = 0; k < 3; k++) {
        int32_t coordinate = crn_scene_i32(check->bytes + at + 4 * k);
        if (coordinate > CRN_SCENE_BODY_REACH_um || coordinate < -CRN_SCENE_BODY_REACH_um)
            return crn_scene_fault_at(check, fault, at + 4 * k);
    }
    uint32_t radius = crn_scene_u32(check->bytes + at + 12);
    if (radius < CRN_SCENE_RADIUS_MIN_um || radius > CRN_SCENE_RADIUS_MAX_um)
        return crn_scene_fault_at(check, fault, at + 12);
    return CRN_SCENE_OK;
}

static crn_scene_status check_points(crn_scene_check *check, size_t where, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        size_t at = where + (size_t)i * CRN_SCENE_TREE_POINT_BYTES;
        const uint8_t *point = check->bytes + at, *before = point - CRN_SCENE_TREE_POINT_BYTES;
        crn_scene_status status = crn_scene_check_tree_point(check, at, CRN_SCENE_TREE_POINT);
        if (status != CRN_SCENE_OK) return status;
        bool has_moved = i == 0;
        for (size_t k = 0; k < 12; k += 4)
            has_moved = has_moved || crn_scene_i32(point + k) != crn_scene_i32(before + k);
        if (!has_moved) return crn_scene_fault_at(check, CRN_SCENE_TREE_POINT, at);
    }
    return CRN_SCENE_OK;
}

/* Parent branches come before their children, so that no branch can be its own ancestor; points follow each
 * other without a gap. */
static crn_scene_status check_branch(crn_scene_check *check, const uint8_t *tree, uint32_t index,
                                     uint32_t *points_before)
{
    const uint8_t *branch = branch_at(tree, index);
    size_t where = (size_t)(branch - check->bytes);
    crn_scene_status status = crn_scene_check_text(check, where, CRN_SCENE_BRANCH_NAME_BYTES);
    if (status != CRN_SCENE_OK) return status;
    int32_t parent = crn_scene_i32(branch + PARENT_AT);
    if (index == 0 ? parent != -1 : parent < 0 || (uint32_t)parent >= index)
        return crn_scene_fault_at(check, CRN_SCENE_TREE_BRANCH, where + PARENT_AT);
    uint32_t places = index == 0 ? 1 : crn_scene_u32(branch_at(tree, (uint32_t)parent) + COUNT_AT);
    if (crn_scene_u32(branch + PARENT_POINT_AT) >= places)
        return crn_scene_fault_at(check, CRN_SCENE_TREE_BRANCH, where + PARENT_POINT_AT);
    uint32_t count = crn_scene_u32(branch + COUNT_AT);
    if (crn_scene_u32(branch + FIRST_AT) != *points_before)
        return crn_scene_fault_at(check, CRN_SCENE_TREE_SIZE, where + FIRST_AT);
    if (count < 2 || count > CRN_SCENE_TREE_POINT_MAX - *points_before)
        return crn_scene_fault_at(check, CRN_SCENE_TREE_SIZE, where + COUNT_AT);
    *points_before += count;
    if (crn_scene_u32(branch + BED_AT) >= CRN_SCENE_BED_COUNT)
        return crn_scene_fault_at(check, CRN_SCENE_TREE_BRANCH, where + BED_AT);
    if (crn_scene_u32(branch + FLOW_AT) > CRN_SCENE_BRANCH_FLOW_MAX_mm3_per_s)
        return crn_scene_fault_at(check, CRN_SCENE_TREE_BRANCH, where + FLOW_AT);
    for (size_t k = 0; k < 8; k++) {
        if (branch[ZERO_AT + k] != 0)
            return crn_scene_fault_at(check, CRN_SCENE_RESERVED, where + ZERO_AT + k);
    }
    return CRN_SCENE_OK;
}

crn_scene_status crn_scene_check_tree(crn_scene_check *check, crn_scene_span span, uint32_t *branch_count)
{
    if (span.size < CRN_SCENE_TREE_HEADER_BYTES)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_SIZE, span.offset);
    const uint8_t *tree = check->bytes + span.offset;
    uint32_t branches = crn_scene_u32(tree), points = crn_scene_u32(tree + 4);
    if (branches == 0 || branches > CRN_SCENE_BRANCH_MAX)
        return crn_scene_fault_at(check, CRN_SCENE_TREE_SIZE, span.offset);
    if (points > CRN_SCENE_TREE_POINT_MAX)
        return crn_scene_fault_at(check, CRN_SCENE_TREE_SIZE, span.offset + 4);
    if (crn_scene_u32(tree + 8) != 0 || crn_scene_u32(tree + 12) != 0)
        return crn_scene_fault_at(check, CRN_SCENE_RESERVED, span.offset + 8);
    if (span.size != CRN_SCENE_TREE_HEADER_BYTES + (uint64_t)branches * CRN_SCENE_BRANCH_BYTES +
                         (uint64_t)points * CRN_SCENE_TREE_POINT_BYTES)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_SIZE, span.offset);
    uint32_t points_before = 0;
    for (uint32_t i = 0; i < branches; i++) {
        crn_scene_status status = check_branch(check, tree, i, &points_before);
        if (status != CRN_SCENE_OK) return status;
    }
    if (points_before != points) return crn_scene_fault_at(check, CRN_SCENE_TREE_SIZE, span.offset + 4);
    size_t at = (size_t)(branch_at(tree, branches) - check->bytes);
    for (uint32_t i = 0; i < branches; i++) {
        uint32_t count = crn_scene_u32(branch_at(tree, i) + COUNT_AT);
        crn_scene_status status = check_points(check, at, count);
        if (status != CRN_SCENE_OK) return status;
        at += (size_t)count * CRN_SCENE_TREE_POINT_BYTES;
    }
    *branch_count = branches;
    return CRN_SCENE_OK;
}
