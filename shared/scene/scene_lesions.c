/* This file checks the LESIONS section of a body file and gives access to the lesions. */
#include "shared/scene/scene_check.h"

/* Gives the fields of a lesion as byte offsets from the lesion's beginning. */
enum {
    BRANCH_AT = 32,
    POINT_AT = 36,
    COUNT_AT = 40,
    FIRST_AT = 44, /* index of its first healthy point in the list of all */
    POINTS_MIN = 3
};

static const uint8_t *lesion_at(const uint8_t *lesions, uint32_t index)
{
    return lesions + CRN_SCENE_LESIONS_HEADER_BYTES + (size_t)index * CRN_SCENE_LESION_BYTES;
}

crn_scene_lesion_view crn_scene_lesion(const crn_scene *scene, uint32_t index)
{
    const uint8_t *lesion = lesion_at(scene->lesions, index);
    crn_scene_lesion_view view;
    view.name = (const char *)lesion;
    view.branch = crn_scene_u32(lesion + BRANCH_AT);
    view.first_point = crn_scene_u32(lesion + POINT_AT);
    view.point_count = crn_scene_u32(lesion + COUNT_AT);
    view.healthy_points = lesion_at(scene->lesions, scene->lesion_count) +
                          (size_t)crn_scene_u32(lesion + FIRST_AT) * CRN_SCENE_TREE_POINT_BYTES;
    return view;
}

/* A lesion must lie on points that its branch has, and the points of its healthy vessel must follow each
 * other without a gap. */
static crn_scene_status check_lesion(crn_scene_check *check, const crn_scene *scene, size_t where,
                                     uint32_t *points_before)
{
    const uint8_t *lesion = check->bytes + where;
    crn_scene_status status = crn_scene_check_text(check, where, CRN_SCENE_BRANCH_NAME_BYTES);
    if (status != CRN_SCENE_OK) return status;
    uint32_t branch = crn_scene_u32(lesion + BRANCH_AT);
    if (branch >= scene->branch_count)
        return crn_scene_fault_at(check, CRN_SCENE_LESION_PLACE, where + BRANCH_AT);
    uint32_t points = crn_scene_branch(scene, branch).point_count;
    uint32_t point = crn_scene_u32(lesion + POINT_AT), count = crn_scene_u32(lesion + COUNT_AT);
    if (point >= points) return crn_scene_fault_at(check, CRN_SCENE_LESION_PLACE, where + POINT_AT);
    if (count < POINTS_MIN || count > points - point)
        return crn_scene_fault_at(check, CRN_SCENE_LESION_PLACE, where + COUNT_AT);
    if (crn_scene_u32(lesion + FIRST_AT) != *points_before)
        return crn_scene_fault_at(check, CRN_SCENE_LESION_SIZE, where + FIRST_AT);
    *points_before += count; /* at most CRN_SCENE_LESION_MAX times the points of a tree: below 2^23 */
    return CRN_SCENE_OK;
}

crn_scene_status crn_scene_check_lesions(crn_scene_check *check, crn_scene_span span, const crn_scene *scene,
                                         uint32_t *lesion_count)
{
    if (span.size < CRN_SCENE_LESIONS_HEADER_BYTES)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_SIZE, span.offset);
    const uint8_t *header = check->bytes + span.offset;
    uint32_t lesions = crn_scene_u32(header), points = crn_scene_u32(header + 4);
    if (lesions == 0 || lesions > CRN_SCENE_LESION_MAX)
        return crn_scene_fault_at(check, CRN_SCENE_LESION_SIZE, span.offset);
    if (crn_scene_u32(header + 8) != 0 || crn_scene_u32(header + 12) != 0)
        return crn_scene_fault_at(check, CRN_SCENE_RESERVED, span.offset + 8);
    if (span.size != CRN_SCENE_LESIONS_HEADER_BYTES + (uint64_t)lesions * CRN_SCENE_LESION_BYTES +
                         (uint64_t)points * CRN_SCENE_TREE_POINT_BYTES)
        return crn_scene_fault_at(check, CRN_SCENE_SECTION_SIZE, span.offset);
    uint32_t points_before = 0;
    for (uint32_t i = 0; i < lesions; i++) {
        crn_scene_status status =
            check_lesion(check, scene, (size_t)(lesion_at(header, i) - check->bytes), &points_before);
        if (status != CRN_SCENE_OK) return status;
    }
    if (points_before != points) return crn_scene_fault_at(check, CRN_SCENE_LESION_SIZE, span.offset + 4);
    size_t at = (size_t)(lesion_at(header, lesions) - check->bytes);
    for (uint32_t i = 0; i < points; i++, at += CRN_SCENE_TREE_POINT_BYTES) {
        crn_scene_status status = crn_scene_check_tree_point(check, at, CRN_SCENE_LESION_PLACE);
        if (status != CRN_SCENE_OK) return status;
    }
    *lesion_count = lesions;
    return CRN_SCENE_OK;
}
