/* Checking and reading the LESIONS section of a body file. */
#include "shared/scene/scene_check.h"

/* Fields of a lesion, as bytes from its beginning. */
enum {
    BRANCH_AT = 32,
    POINT_AT = 36,
    COUNT_AT = 40,
    FIRST_AT = 44, /* of its healthy points in the list of all */
    POINTS_MIN = 3
};

static const uint8_t *lesion_at(const uint8_t *lesions, uint32_t index)
{
    return lesions + SELD_SCENE_LESIONS_HEADER_BYTES + (size_t)index * SELD_SCENE_LESION_BYTES;
}

seld_scene_lesion_view seld_scene_lesion(const seld_scene *scene, uint32_t index)
{
    const uint8_t *lesion = lesion_at(scene->lesions, index);
    seld_scene_lesion_view view;
    view.name = (const char *)lesion;
    view.branch = seld_scene_u32(lesion + BRANCH_AT);
    view.first_point = seld_scene_u32(lesion + POINT_AT);
    view.point_count = seld_scene_u32(lesion + COUNT_AT);
    view.healthy_points = lesion_at(scene->lesions, scene->lesion_count) +
                          (size_t)seld_scene_u32(lesion + FIRST_AT) * SELD_SCENE_TREE_POINT_BYTES;
    return view;
}

/* On points that its branch has; healthy points follow each other without a gap. */
static seld_scene_status check_lesion(seld_scene_check *check, const seld_scene *scene, size_t where,
                                      uint32_t *points_before)
{
    const uint8_t *lesion = check->bytes + where;
    seld_scene_status status = seld_scene_check_text(check, where, SELD_SCENE_BRANCH_NAME_BYTES);
    if (status != SELD_SCENE_OK) return status;
    uint32_t branch = seld_scene_u32(lesion + BRANCH_AT);
    if (branch >= scene->branch_count)
        return seld_scene_fault_at(check, SELD_SCENE_LESION_PLACE, where + BRANCH_AT);
    uint32_t points = seld_scene_branch(scene, branch).point_count;
    uint32_t point = seld_scene_u32(lesion + POINT_AT), count = seld_scene_u32(lesion + COUNT_AT);
    if (point >= points) return seld_scene_fault_at(check, SELD_SCENE_LESION_PLACE, where + POINT_AT);
    if (count < POINTS_MIN || count > points - point)
        return seld_scene_fault_at(check, SELD_SCENE_LESION_PLACE, where + COUNT_AT);
    if (seld_scene_u32(lesion + FIRST_AT) != *points_before)
        return seld_scene_fault_at(check, SELD_SCENE_LESION_SIZE, where + FIRST_AT);
    *points_before += count; /* at most SELD_SCENE_LESION_MAX times the points of a tree: below 2^23 */
    return SELD_SCENE_OK;
}

seld_scene_status seld_scene_check_lesions(seld_scene_check *check, seld_scene_span span,
                                           const seld_scene *scene, uint32_t *lesion_count)
{
    if (span.size < SELD_SCENE_LESIONS_HEADER_BYTES)
        return seld_scene_fault_at(check, SELD_SCENE_SECTION_SIZE, span.offset);
    const uint8_t *header = check->bytes + span.offset;
    uint32_t lesions = seld_scene_u32(header), points = seld_scene_u32(header + 4);
    if (lesions == 0 || lesions > SELD_SCENE_LESION_MAX)
        return seld_scene_fault_at(check, SELD_SCENE_LESION_SIZE, span.offset);
    if (seld_scene_u32(header + 8) != 0 || seld_scene_u32(header + 12) != 0)
        return seld_scene_fault_at(check, SELD_SCENE_RESERVED, span.offset + 8);
    if (span.size != SELD_SCENE_LESIONS_HEADER_BYTES + (uint64_t)lesions * SELD_SCENE_LESION_BYTES +
                         (uint64_t)points * SELD_SCENE_TREE_POINT_BYTES)
        return seld_scene_fault_at(check, SELD_SCENE_SECTION_SIZE, span.offset);
    uint32_t points_before = 0;
    for (uint32_t i = 0; i < lesions; i++) {
        seld_scene_status status =
            check_lesion(check, scene, (size_t)(lesion_at(header, i) - check->bytes), &points_before);
        if (status != SELD_SCENE_OK) return status;
    }
    if (points_before != points) return seld_scene_fault_at(check, SELD_SCENE_LESION_SIZE, span.offset + 4);
    size_t at = (size_t)(lesion_at(header, lesions) - check->bytes);
    for (uint32_t i = 0; i < points; i++, at += SELD_SCENE_TREE_POINT_BYTES) {
        seld_scene_status status = seld_scene_check_tree_point(check, at, SELD_SCENE_LESION_PLACE);
        if (status != SELD_SCENE_OK) return status;
    }
    *lesion_count = lesions;
    return SELD_SCENE_OK;
}
