/* This header has the declarations that the parts of the scene check share. */
#ifndef CRN_SCENE_CHECK_H
#define CRN_SCENE_CHECK_H

#include "shared/scene/scene.h"

typedef struct crn_scene_check {
    const uint8_t *bytes;
    size_t size;
    crn_scene_kind kind;
    uint16_t minor;
    uint32_t section_count;
    uint32_t content_count; /* sections without a body file's PARTNER, which is its last section */
    size_t table_end;
    uint32_t where; /* of the fault */
} crn_scene_check;

typedef struct crn_scene_span {
    uint32_t type;
    uint32_t offset;
    uint32_t size;
} crn_scene_span;

/* Stores the byte position of a fault and returns the status. */
crn_scene_status crn_scene_fault_at(crn_scene_check *check, crn_scene_status status, size_t where);

/* Returns row `index` of the section table; the function does not check the index. */
crn_scene_span crn_scene_section_span(const uint8_t *bytes, uint32_t index);

/* Checks a text field of `capacity` bytes: the text has at most capacity - 1 bytes, and the remaining bytes
 * must be zeros. */
crn_scene_status crn_scene_check_text(crn_scene_check *check, size_t where, size_t capacity);

crn_scene_status crn_scene_check_lumen(crn_scene_check *check, crn_scene_span span, crn_scene_lumen *lumen);
/* Checks a MOTION section or a BREATH section; the type of `span` decides which of the two. */
crn_scene_status crn_scene_check_motion(crn_scene_check *check, crn_scene_span span,
                                        crn_scene_motion *motion);
crn_scene_status crn_scene_check_bodies(crn_scene_check *check, uint32_t body_count);
crn_scene_status crn_scene_check_tree(crn_scene_check *check, crn_scene_span span, uint32_t *branch_count);
/* The vessel tree must have passed its own check before the small vessels are checked. */
crn_scene_status crn_scene_check_small(crn_scene_check *check, crn_scene_span span, const crn_scene *scene,
                                       uint32_t *small_count);
/* The vessel tree must have passed its own check before the lesions are checked. */
crn_scene_status crn_scene_check_lesions(crn_scene_check *check, crn_scene_span span, const crn_scene *scene,
                                         uint32_t *lesion_count);
crn_scene_status crn_scene_check_plaques(crn_scene_check *check, crn_scene_span span, uint32_t *plaque_count);
/* The lumen must have passed its own check before the walls are checked. */
crn_scene_status crn_scene_check_walls(crn_scene_check *check, crn_scene_span span, crn_scene *scene);
/* Checks that a point's coordinates are not too far from the origin and its radius is in range. */
crn_scene_status crn_scene_check_tree_point(crn_scene_check *check, size_t at, crn_scene_status fault);

#endif
