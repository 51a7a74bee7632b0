/* This header writes a tube as the file of a scene that a device takes. */
#ifndef CRN_REFERENCE_TUBE_SCENE_H
#define CRN_REFERENCE_TUBE_SCENE_H

#include "firmware/tests/reference/tube_lumen.h"

/* Writes a scene with the tube's lumen, and an entry at the origin along +x. Returns its size, or 0 if it
 * does not fit. */
size_t reference_tube_scene(const reference_tube *tube, uint8_t *file, size_t capacity);

#endif
