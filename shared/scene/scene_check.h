/* What the parts of the scene check share. May include: scene.h. Called by: scene*.c only. */
#ifndef SELD_SCENE_CHECK_H
#define SELD_SCENE_CHECK_H

#include "shared/scene/scene.h"

typedef struct seld_scene_check {
    const uint8_t *bytes;
    size_t size;
    seld_scene_kind kind;
    uint16_t minor;
    uint32_t section_count;
    uint32_t content_count; /* without a body file's PARTNER, which is its last section */
    size_t table_end;
    uint32_t where; /* of the fault */
} seld_scene_check;

typedef struct seld_scene_span {
    uint32_t type;
    uint32_t offset;
    uint32_t size;
} seld_scene_span;

/* Remember the place, return the status. */
seld_scene_status seld_scene_fault_at(seld_scene_check *check, seld_scene_status status, size_t where);

/* Row `index` of the section table; not checked. */
seld_scene_span seld_scene_section_span(const uint8_t *bytes, uint32_t index);

/* A text of at most capacity - 1 bytes, filled up with zeros. */
seld_scene_status seld_scene_check_text(seld_scene_check *check, size_t where, size_t capacity);

seld_scene_status seld_scene_check_lumen(seld_scene_check *check, seld_scene_span span,
                                         seld_scene_lumen *lumen);
/* MOTION or BREATH, as the span's type says. */
seld_scene_status seld_scene_check_motion(seld_scene_check *check, seld_scene_span span,
                                          seld_scene_motion *motion);
seld_scene_status seld_scene_check_bodies(seld_scene_check *check, uint32_t body_count);
seld_scene_status seld_scene_check_tree(seld_scene_check *check, seld_scene_span span,
                                        uint32_t *branch_count);
/* Of a tree that has passed its check. */
seld_scene_status seld_scene_check_lesions(seld_scene_check *check, seld_scene_span span,
                                           const seld_scene *scene, uint32_t *lesion_count);
seld_scene_status seld_scene_check_plaques(seld_scene_check *check, seld_scene_span span,
                                           uint32_t *plaque_count);
/* Coordinates of a point within reach and a radius in range. */
seld_scene_status seld_scene_check_tree_point(seld_scene_check *check, size_t at, seld_scene_status fault);

#endif
