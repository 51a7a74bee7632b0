/* This header provides vessels that move by a closed form, for tests, benchmarks and validation. The
 * functions of this header make the displacement lattice that the scene baker would make, node by node from
 * the inverse map, and compute the map itself in double precision. */
#ifndef CRN_REFERENCE_MOVING_TUBE_H
#define CRN_REFERENCE_MOVING_TUBE_H

#include "firmware/core/core.h"
#include "firmware/core/motion.h"
#include "firmware/tests/reference/tube_lumen.h"

/* Maps a wall point at X in the reference pose to its position at a phase of the heartbeat (0 .. 1) and a
 * depth of breath (0 .. 1). */
typedef void (*reference_map)(const double *X_m, double phase, double breath, double *x_m);

typedef struct reference_motion {
    reference_map map;
    crn_motion motion; /* it owns rows and inhaled */
} reference_motion;

/* Makes a displacement lattice over a box; the distance between two nodes is 2^spacing_log2_q30 in units of
 * 2^-30 m. The lattice's outermost nodes do not move, so the box must be larger than everything that moves,
 * or larger than the region whose displacements a test reads. */
reference_motion *reference_motion_make(reference_map map, const double *low_m, const double *high_m,
                                        uint32_t spacing_log2_q30);
void reference_motion_free(reference_motion *motion);

/* Finds the point X of the reference pose that the map moves to x, by fixed-point iteration. The displacement
 * w(x) = X - x from a point x to its point X in the reference pose is exact. */
void reference_pull(reference_map map, const double *x_m, double phase, double breath, double *X_m);

/* Returns the contraction of a heart whose largest contraction is 1. The contraction is 0 at phase 0 (end of
 * filling) and 1 at the end of systole, and changes smoothly in between. */
double reference_contraction(double phase);

/* Moves a point with a beating sphere whose middle is at (90, 5, 45) mm. The sphere shrinks by 30 %, moves 6
 * mm along -y and turns by 12 degrees about the y axis through its middle; points 40 mm from the middle move
 * by up to 11 mm. In the test's breathing motion, the sphere and its surroundings move by 8 mm along -y. The
 * sphere's beat and its motion by breath fade out at 90 mm from its middle. */
void reference_beating_sphere(const double *X_m, double phase, double breath, double *x_m);

/* The following constants give the pieces of a vessel and the box in which the vessel moves. The vessel
 * begins at the origin and runs round the beating sphere, 40 mm from the sphere's middle. */
extern const reference_piece reference_coronary[3];
extern const double reference_coronary_low_m[3], reference_coronary_high_m[3];

/* Makes displacement lattices as steep as those of the shipped heart, without a closed form. In the lattices
 * of reference_waves_make, every point moves by up to 5 mm along each axis in a heartbeat, with waves of 250
 * mm, and by 3.2 mm in a breath. The motion fades to 0 over the four outer lattice cells of the box. */
reference_motion *reference_waves_make(const double *low_m, const double *high_m, uint32_t spacing_log2_q30);

/* Makes a 0.014 in wire of 400 mm with a soft tip. */
crn_instrument reference_coronary_wire(void);

#endif
