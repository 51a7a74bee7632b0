/* Vessels that move: where the point of the wall that is here now lies in the pose the lumen was described in.
 *
 * A coarse lattice in the room holds, for each of its nodes, the way w from the node to the reference pose: X = x + w(x). So a
 * world point is pulled back by one look-up, without iteration, and the wall is where phi(x + w(x)) = 0. In a cell w is
 * trilinear. In time it is the periodic quadratic B-spline of 24 coefficients (C1; the baker prefilters, so that it passes
 * through the keyframes), plus a second field times the depth of breath. Outside the lattice, and on its boundary, w = 0.
 *
 *     gradient of the depth used    g = (I + J)^T grad phi,  J = dw/dx
 *     step of the wall in a tick    -(I + J)^-1 (w now - w before)
 *
 * docs/heart.md has the equations and what they cost. May include: lumen.h, rhythm.h. Called by: contact. Checked before use by
 * shared/scene (hostile until checked).
 */
#ifndef SELD_MOTION_H
#define SELD_MOTION_H

#include "firmware/core/lumen.h"
#include "firmware/core/rhythm.h"

enum {
    SELD_MOTION_KEYFRAMES = 24,
    SELD_MOTION_ROW = 28, /* numbers of one component of one node */
    SELD_MOTION_ROW_BREATH = 26,
    SELD_MOTION_UNIT_LOG2_Q30 = 11,            /* of a coefficient: 2^11 / 2^30 m = 1.9 um */
    SELD_MOTION_COEFFICIENT_MAX = 1 << 14,     /* 31 mm */
    SELD_MOTION_SPACING_LOG2_MIN = 20,         /* 0.98 mm */
    SELD_MOTION_SPACING_LOG2_MAX = 24,         /* 15.6 mm */
    SELD_MOTION_WALL_STEP_MAX_M_Q33 = 1 << 24, /* 2 mm in a tick: nothing in a body moves so fast */
};

typedef struct seld_motion {
    int32_t origin_m_q30[3]; /* node (0,0,0) */
    uint32_t count_xyz[3];   /* nodes along each axis, at least 2 */
    uint32_t spacing_log2_q30;
    /* Node by node, x fastest; three components each; of a component: coefficients of keyframes 23, 0, 1 .. 23, 0, then
     * that of breath, then 0. Neighbours differ by at most 5/8 of a spacing (breath: 3/8). */
    const int16_t *rows;
} seld_motion;

/* A moment of heart and breath: which three coefficients count how much. */
typedef struct seld_motion_moment {
    uint32_t first; /* in a row, 0 .. 23 */
    int32_t weights_q15[3];
    int32_t breath_q15;
} seld_motion_moment;

/* What was blended of a cell, kept for the next point in it or in a neighbour. */
typedef struct seld_motion_cell {
    uint32_t node; /* its low node; UINT32_MAX: none */
    seld_vec3 corners_m_q34[8];
} seld_motion_cell;

/* Two moments, and what of the lattice was made for them last: nodes of a wire lie in the same cell one after the other. */
typedef struct seld_motion_pose {
    seld_motion_moment now, before;
    uint32_t corner_rows[8];   /* numbers from a cell's low node to its corners */
    seld_motion_cell ways;     /* from the corners to the reference pose */
    seld_motion_cell changes;  /* of these in the tick */
    int32_t fraction_q31[3];   /* of the last point pulled back */
    int32_t edges_m_q34[3][4]; /* there, on the cell's four edges along x */
    seld_vec3 reference_m_q30; /* where it was pulled to, after seld_motion_distance or seld_motion_contact */
    int32_t gradient_q28[3][3]; /* I + dw_i/dx_j there, once it has_gradient */
    bool has_gradient;
    bool is_inside; /* it lay in the lattice */
} seld_motion_pose;

seld_motion_moment seld_motion_moment_at(uint32_t heart_phase32, uint32_t breath_phase32);

/* For a tick that leads from one moment to another. */
void seld_motion_pose_begin(const seld_motion *motion, seld_motion_pose *pose, const seld_rhythm *before,
                            const seld_rhythm *now);

/* Place in the reference pose of what is at `world` now. Format: Q30 m. Overflow: saturates. Error against the exact spline of the
 * stored coefficients: 1 um (weights of 15 bits; firmware/tests/test_motion.c). */
seld_vec3 seld_motion_pull(const seld_motion *motion, seld_motion_pose *pose, const seld_vec3 *world_m_q30);

/* 1 / the most that this lattice lengthens a gradient: |(I + J)^T n| <= 1 + |J|, and |J|^2 is at most the sum over the axes of the longest
 * difference of neighbours along each, squared. For set-up: reads all of it. Format: Q30, in (0, 1]. */
int32_t seld_motion_shrink_q30(const seld_motion *motion);

/* At or beyond the wall at least 0, else no less than the distance that seld_motion_contact gives there: the lumen's, made smaller by the most
 * that a gradient is lengthened, by `shrink` in the whole lattice or, where the distance is not below `far` by it, here. */
int32_t seld_motion_distance(const seld_lumen *lumen, const seld_motion *motion, seld_motion_pose *pose,
                             const seld_vec3 *world_m_q30, int32_t shrink_q30, int32_t far_m_q30);

/* As seld_lumen_contact of the moved wall: distance phi / |g| (exact at the wall), normal -g / |g|. */
seld_lumen_sample seld_motion_contact(const seld_lumen *lumen, const seld_motion *motion,
                                      seld_motion_pose *pose, const seld_vec3 *world_m_q30);
/* The same at the place of the last seld_motion_distance. */
seld_lumen_sample seld_motion_contact_here(const seld_lumen *lumen, const seld_motion *motion,
                                           seld_motion_pose *pose);

/* Way of the wall in this tick at the place of the last contact. Format: Q33 m, limited to SELD_MOTION_WALL_STEP_MAX. */
seld_vec3 seld_motion_wall_step(const seld_motion *motion, seld_motion_pose *pose);

#endif
