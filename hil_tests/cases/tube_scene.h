/* A small scene from a closed form for cases that need a wall: a tube of 2 mm around a path with a bend.
 * May include: nothing. Called by: cases. */
#ifndef SELD_HIL_TUBE_SCENE_H
#define SELD_HIL_TUBE_SCENE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Writes the scene file; returns its size, or 0 when `capacity` is too small. The entry is the origin, along +x. */
size_t hil_tube_scene(uint8_t *file, size_t capacity);

#ifdef __cplusplus
}
#endif

#endif
