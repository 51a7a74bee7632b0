/* Laying out a scene container: header, section table, CRCs and padding, into memory of the caller.
 * May include: scene.h. Called by: tools/bake, tests. C11 and C++20. */
#ifndef SELD_SCENE_WRITE_H
#define SELD_SCENE_WRITE_H

#include "shared/scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct seld_scene_part {
    seld_scene_section type;
    const uint8_t *bytes;
    size_t size;
} seld_scene_part;

/* Bytes of a file with these sections; 0 when it would exceed 2^31. */
size_t seld_scene_write_bytes(const seld_scene_part *parts, uint32_t part_count);

/* Write them. Returns the bytes written, or 0 when `capacity` is too small. Contents are not checked: open the result. */
size_t seld_scene_write(seld_scene_kind kind, const seld_scene_part *parts, uint32_t part_count,
                        uint8_t *file, size_t capacity);

/* Little-endian words. */
void seld_scene_put_u16(uint8_t *bytes, uint16_t value);
void seld_scene_put_u32(uint8_t *bytes, uint32_t value);

#ifdef __cplusplus
}
#endif

#endif
