/* This header declares functions that write a scene container (header, section table, CRCs and padding) into
 * memory of the caller. C11 and C++20. */
#ifndef CRN_SCENE_WRITE_H
#define CRN_SCENE_WRITE_H

#include "shared/scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct crn_scene_part {
    crn_scene_section type;
    const uint8_t *bytes;
    size_t size;
} crn_scene_part;

/* Returns the size in bytes of a file with the given sections, or 0 when the size would exceed 2^31. */
size_t crn_scene_write_bytes(const crn_scene_part *parts, uint32_t part_count);

/* Writes the sections. Returns the number of bytes written, or 0 when `capacity` is too small. The writing
 * function does not check the contents of the sections; the caller opens the written file to check them. */
size_t crn_scene_write(crn_scene_kind kind, const crn_scene_part *parts, uint32_t part_count, uint8_t *file,
                       size_t capacity);

/* Little-endian words. */
void crn_scene_put_u16(uint8_t *bytes, uint16_t value);
void crn_scene_put_u32(uint8_t *bytes, uint32_t value);

#ifdef __cplusplus
}
#endif

#endif
