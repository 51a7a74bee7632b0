/* This file checks the sections TREE and SMALL of a body file, and gives access to the vessels in them. */
#include "shared/scene/scene_check.h"

/* Gives the fields of a branch as byte offsets from the branch's beginning. */
enum {
    PARENT_AT = 32,
    PARENT_POINT_AT = 36,
    FIRST_AT = 40,
    COUNT_AT = 44,
    BED_AT = 48,
    FLOW_AT = 52,
    FLAGS_AT = 56,
    JOINS_AT = 60
};

static const uint8_t *branch_at(const uint8_t *tree, uint32_t index)
{
    return tree + CRN_SCENE_TREE_HEADER_BYTES + (size_t)index * CRN_SCENE_BRANCH_BYTES;
}

static crn_scene_branch_view view_of(const uint8_t *table, uint32_t count, uint32_t index)
{
    const uint8_t *branch = branch_at(table, index);
    crn_scene_branch_view view;
    view.name = (const char *)branch;
    view.parent = crn_scene_i32(branch + PARENT_AT);
    view.parent_point = crn_scene_u32(branch + PARENT_POINT_AT);
    view.point_count = crn_scene_u32(branch + COUNT_AT);
    view.bed = (crn_scene_bed)crn_scene_u32(branch + BED_AT);
    view.flow_mm3_per_s = crn_scene_u32(branch + FLOW_AT);
    view.flags = crn_scene_u32(branch + FLAGS_AT);
    view.joins = crn_scene_u32(branch + JOINS_AT);
    view.points =
        branch_at(table, count) + (size_t)crn_scene_u32(branch + FIRST_AT) * CRN_SCENE_TREE_POINT_BYTES;
    return view;
}

crn_scene_branch_view crn_scene_branch(const crn_scene *scene, uint32_t index)
{
    return view_of(scene->tree, scene->branch_count, index);
}

crn_scene_branch_view crn_scene_small(const crn_scene *scene, uint32_t index)
{
    return view_of(scene->small, scene->small_count, index);
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

/* A table of branches: the tree, or its small vessels. `before` is the tree to which small vessels belong;
 * their indices continue those of the tree's branches. */
typedef struct branch_table {
    const uint8_t *bytes, *before;
    uint32_t count, count_before, bed_count, flow_max, flags_allowed;
} branch_table;

/* A branch without a parent is the first one of the tree, or a vein. */
static bool parent_fits(const branch_table *table, int32_t parent, uint32_t index, uint32_t flags)
{
    const uint32_t whole_index = table->count_before + index;
    if (parent == -1) return whole_index == 0 || (flags & CRN_SCENE_BRANCH_IS_VEIN) != 0;
    return whole_index > 0 && parent >= 0 && (uint32_t)parent < whole_index;
}

/* Only an artery joins another vessel, which is a small one, too. Without the flag the field is 0. */
static crn_scene_status check_joining(crn_scene_check *check, const branch_table *table, uint32_t index,
                                      uint32_t flags, size_t where)
{
    const uint32_t joins = crn_scene_u32(check->bytes + where + JOINS_AT);
    if ((flags & CRN_SCENE_BRANCH_JOINS) == 0)
        return joins == 0 ? CRN_SCENE_OK : crn_scene_fault_at(check, CRN_SCENE_RESERVED, where + JOINS_AT);
    const bool fits = (flags & CRN_SCENE_BRANCH_IS_VEIN) == 0 && joins >= table->count_before &&
                      joins - table->count_before < table->count && joins - table->count_before != index;
    if (!fits) return crn_scene_fault_at(check, CRN_SCENE_TREE_BRANCH, where + JOINS_AT);
    const uint8_t *other = branch_at(table->bytes, joins - table->count_before);
    if ((crn_scene_u32(other + FLAGS_AT) & CRN_SCENE_BRANCH_IS_VEIN) != 0)
        return crn_scene_fault_at(check, CRN_SCENE_TREE_BRANCH, where + JOINS_AT);
    return CRN_SCENE_OK;
}

static uint32_t points_of_parent(const branch_table *table, int32_t parent)
{
    if (parent < 0) return 1;
    const uint32_t index = (uint32_t)parent;
    const uint8_t *branch = index < table->count_before
                                ? branch_at(table->before, index)
                                : branch_at(table->bytes, index - table->count_before);
    return crn_scene_u32(branch + COUNT_AT);
}

/* Parent branches come before their children, so that no branch can be its own ancestor; points follow each
 * other without a gap. */
static crn_scene_status check_branch(crn_scene_check *check, const branch_table *table, uint32_t index,
                                     uint32_t *points_before)
{
    const uint8_t *branch = branch_at(table->bytes, index);
    size_t where = (size_t)(branch - check->bytes);
    crn_scene_status status = crn_scene_check_text(check, where, CRN_SCENE_BRANCH_NAME_BYTES);
    if (status != CRN_SCENE_OK) return status;
    const uint32_t flags = crn_scene_u32(branch + FLAGS_AT);
    if ((flags & ~table->flags_allowed) != 0)
        return crn_scene_fault_at(check, CRN_SCENE_RESERVED, where + FLAGS_AT);
    int32_t parent = crn_scene_i32(branch + PARENT_AT);
    if (!parent_fits(table, parent, index, flags))
        return crn_scene_fault_at(check, CRN_SCENE_TREE_BRANCH, where + PARENT_AT);
    if (crn_scene_u32(branch + PARENT_POINT_AT) >= points_of_parent(table, parent))
        return crn_scene_fault_at(check, CRN_SCENE_TREE_BRANCH, where + PARENT_POINT_AT);
    uint32_t count = crn_scene_u32(branch + COUNT_AT);
    if (crn_scene_u32(branch + FIRST_AT) != *points_before)
        return crn_scene_fault_at(check, CRN_SCENE_TREE_SIZE, where + FIRST_AT);
    if (count < 2 || count > CRN_SCENE_TREE_POINT_MAX - *points_before)
        return crn_scene_fault_at(check, CRN_SCENE_TREE_SIZE, where + COUNT_AT);
    *points_before += count;
    if (crn_scene_u32(branch + BED_AT) >= table->bed_count)
        return crn_scene_fault_at(check, CRN_SCENE_TREE_BRANCH, where + BED_AT);
    if (crn_scene_u32(branch + FLOW_AT) > table->flow_max)
        return crn_scene_fault_at(check, CRN_SCENE_TREE_BRANCH, where + FLOW_AT);
    return check_joining(check, table, index, flags, where);
}

static crn_scene_status check_table(crn_scene_check *check, crn_scene_span span, branch_table *table,
                                    uint32_t branch_max)
{
    if (span.size < CRN_SCENE_TREE_HEADER_BYTES)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_SIZE, span.offset);
    table->bytes = check->bytes + span.offset;
    uint32_t branches = crn_scene_u32(table->bytes), points = crn_scene_u32(table->bytes + 4);
    table->count = branches;
    if (branches == 0 || branches > branch_max)
        return crn_scene_fault_at(check, CRN_SCENE_TREE_SIZE, span.offset);
    if (points > CRN_SCENE_TREE_POINT_MAX)
        return crn_scene_fault_at(check, CRN_SCENE_TREE_SIZE, span.offset + 4);
    if (crn_scene_u32(table->bytes + 8) != 0 || crn_scene_u32(table->bytes + 12) != 0)
        return crn_scene_fault_at(check, CRN_SCENE_RESERVED, span.offset + 8);
    if (span.size != CRN_SCENE_TREE_HEADER_BYTES + (uint64_t)branches * CRN_SCENE_BRANCH_BYTES +
                         (uint64_t)points * CRN_SCENE_TREE_POINT_BYTES)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_SIZE, span.offset);
    uint32_t points_before = 0;
    for (uint32_t i = 0; i < branches; i++) {
        crn_scene_status status = check_branch(check, table, i, &points_before);
        if (status != CRN_SCENE_OK) return status;
    }
    if (points_before != points) return crn_scene_fault_at(check, CRN_SCENE_TREE_SIZE, span.offset + 4);
    size_t at = (size_t)(branch_at(table->bytes, branches) - check->bytes);
    for (uint32_t i = 0; i < branches; i++) {
        uint32_t count = crn_scene_u32(branch_at(table->bytes, i) + COUNT_AT);
        crn_scene_status status = check_points(check, at, count);
        if (status != CRN_SCENE_OK) return status;
        at += (size_t)count * CRN_SCENE_TREE_POINT_BYTES;
    }
    return CRN_SCENE_OK;
}

crn_scene_status crn_scene_check_tree(crn_scene_check *check, crn_scene_span span, uint32_t *branch_count)
{
    branch_table table = {.bed_count = CRN_SCENE_BED_KIDNEY, .flow_max = CRN_SCENE_BRANCH_FLOW_MAX_mm3_per_s};
    crn_scene_status status = check_table(check, span, &table, CRN_SCENE_BRANCH_MAX);
    if (status == CRN_SCENE_OK) *branch_count = table.count;
    return status;
}

crn_scene_status crn_scene_check_small(crn_scene_check *check, crn_scene_span span, const crn_scene *scene,
                                       uint32_t *small_count)
{
    branch_table table = {.before = scene->tree,
                          .count_before = scene->branch_count,
                          .bed_count = CRN_SCENE_BED_COUNT,
                          .flow_max = CRN_SCENE_SMALL_FLOW_MAX_nl_per_s,
                          .flags_allowed = CRN_SCENE_BRANCH_IS_VEIN | CRN_SCENE_BRANCH_JOINS};
    crn_scene_status status = check_table(check, span, &table, CRN_SCENE_SMALL_MAX);
    if (status == CRN_SCENE_OK) *small_count = table.count;
    return status;
}
