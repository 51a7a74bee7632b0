/* Makes scenes for test cases that need a vessel wall: tubes around a path of straight pieces and bends. In
 * the tube scenes, a formula gives the distance to the wall. */
#ifndef CRN_HIL_TUBE_SCENE_H
#define CRN_HIL_TUBE_SCENE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { HIL_PIECES_MAX = 4 };

typedef struct hil_piece {
    double length_m, angle_rad; /* 0: straight */
} hil_piece;

/* Writes the scene file of a closed tube to `file`; returns the size of the file in bytes, or 0 if `capacity`
 * is too small. The tools enter at the origin, in the direction +x. `level` (0 or 1) is the number of times
 * that the distance field is refined. */
size_t hil_scene_of(const hil_piece *pieces, uint32_t count, double radius_m, uint32_t level, uint8_t *file,
                    size_t capacity);

/* Makes the scene of a tube of 2 mm radius with one bend. */
size_t hil_tube_scene(uint8_t *file, size_t capacity);

#ifdef __cplusplus
}
#endif

#endif
