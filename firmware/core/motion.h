/* Vessels that move: where the point of the wall that is here now lies in the pose the lumen was described
 * in.
 *
 * Two coarse lattices in the room: breath's is undone first, then the heart's, as a chest carries the heart
 * that beats in it.
 *
 *     X1 = x + depth b(x),  X = X1 + w(X1)
 *
 * So a world point is pulled back by look-ups, without iteration, and the wall is where phi(X) = 0. In a cell
 * w is trilinear; b, which is smooth, is plane in each of its six tetrahedra (Kuhn), a third of the work. In
 * time w is the periodic quadratic B-spline of 24 coefficients (C1; the baker prefilters, so that it passes
 * through the keyframes). Outside a lattice, and on its boundary, w = 0 and b = 0.
 *
 *     gradient of the depth used    g = (I + depth db/dx)^T (I + dw/dx)^T grad phi
 *     step of the wall in a tick    -(I + depth db/dx)^-1 ((I + dw/dx)^-1 (w now - w before) + (depth now - depth before) b)
 *
 * docs/heart.md has the equations and what they cost. Checked before use by
 * shared/scene (hostile until checked).
 */
#ifndef CRN_MOTION_H
#define CRN_MOTION_H

#include "firmware/core/lumen.h"
#include "firmware/core/rhythm.h"

enum {
    CRN_MOTION_KEYFRAMES = 24,
    CRN_MOTION_ROW = 26,                      /* numbers of one component of one node of the beat */
    CRN_MOTION_UNIT_LOG2_Q30 = 11,            /* of a coefficient: 2^11 / 2^30 m = 1.9 um */
    CRN_MOTION_COEFFICIENT_MAX = 1 << 14,     /* 31 mm */
    CRN_MOTION_SPACING_LOG2_MIN = 20,         /* 0.98 mm */
    CRN_MOTION_SPACING_LOG2_MAX = 24,         /* 15.6 mm */
    CRN_MOTION_WALL_STEP_MAX_M_Q33 = 1 << 24, /* 2 mm in a tick: nothing in a body moves so fast */
};

typedef struct crn_lattice {
    int32_t origin_m_q30[3]; /* node (0,0,0) */
    uint32_t count_xyz[3];   /* nodes along each axis, at least 2 */
    uint32_t spacing_log2_q30;
} crn_lattice;

typedef struct crn_motion {
    crn_lattice beat;
    /* Node by node, x fastest; three components each; of a component the coefficients of keyframes 23, 0, 1
     * .. 23, 0. Neighbours differ by at most 5/8 of a spacing. */
    const int16_t *rows;
    crn_lattice breath;
    /* b: node by node, x fastest, three components each; neighbours differ by at most 3/8 of a spacing. NULL:
     * it does not breathe. */
    const int16_t *inhaled;
} crn_motion;

/* A moment of heart and breath: which three coefficients count how much. */
typedef struct crn_motion_moment {
    uint32_t first; /* in a row, 0 .. 23 */
    int32_t weights_q15[3];
    int32_t breath_q15;
} crn_motion_moment;

/* What was blended of a cell's corners, kept for the next point in it or in a neighbour. */
typedef struct crn_motion_cell {
    uint32_t node; /* its low node; UINT32_MAX: none */
    crn_vec3 corners_m_q34[8];
} crn_motion_cell;

/* What of one lattice was made for the last point. */
typedef struct crn_motion_field {
    uint32_t corner_rows[8]; /* numbers from a cell's low node to its corners */
    crn_motion_cell ways;    /* from the corners back; of breath: of a full one */
    /* The same as polynomials: of the beat of 1, x, y, xy, z, xz, yz, xyz; of breath of 1, x, y, -, z, in the
     * tetrahedron of the last point. */
    int32_t terms_m_q34[3][8];
    int32_t low_m_q30[3];  /* place of the cell's low node */
    int32_t powers_q31[8]; /* x, y, xy, z, xz, yz, xyz of the last point pulled back, from [1] on */
    uint32_t tetrahedron;  /* of breath: which of the cell's */
    int32_t shrink_q30;    /* of breath there; 0: not made */
    bool is_inside;        /* the point lay in the lattice */
} crn_motion_field;

/* Two moments, and what of the lattices was made for them last: nodes of a wire lie in the same cell one
 * after the other. */
typedef struct crn_motion_pose {
    crn_motion_moment now, before;
    crn_motion_field beat, breath;
    crn_motion_cell changes; /* of the beat's ways in the tick */
    crn_vec3 inhaled_m_q34;  /* b at the last point */
    int32_t low_m_q30[3];    /* a box about both lattices: beyond it nothing moves */
    uint32_t size_m_q30[3];
    /* Where the last point was pulled to, after crn_motion_distance or crn_motion_contact. */
    crn_vec3 reference_m_q30;
    int32_t gradient_q28[3][3]; /* I + dw_i/dx_j there, once it has_gradient */
    bool has_gradient;
} crn_motion_pose;

crn_motion_moment crn_motion_moment_at(uint32_t heart_phase32, uint32_t breath_phase32);

/* For a tick that leads from one moment to another. */
void crn_motion_pose_begin(const crn_motion *motion, crn_motion_pose *pose, const crn_rhythm *before,
                           const crn_rhythm *now);

/* Place in the reference pose of what is at `world` now. Format: Q30 m. Overflow: saturates. Error against
 * the exact spline of the stored coefficients: 1 um (weights of 15 bits; firmware/tests/test_motion.c). */
crn_vec3 crn_motion_pull(const crn_motion *motion, crn_motion_pose *pose, const crn_vec3 *world_m_q30);

/* How steep a motion is anywhere: |J| at most, of each coefficient in a row and of a full breath. |J|^2 is at
 * most the sum over the axes of the longest difference of neighbours along each, squared. Format: Q28, at
 * most 1.1. */
typedef struct crn_motion_steepness {
    int32_t beat_q28[CRN_MOTION_ROW];
    int32_t breath_q28;
} crn_motion_steepness;

/* For set-up: reads all of the lattices. */
void crn_motion_steepness_make(const crn_motion *motion, crn_motion_steepness *steepness);

/* 1 / the most that the motion lengthens a gradient at a moment: |(I + J)^T n| <= 1 + |J| for each of the two
 * factors, and |J| of a blend is at most the blend of its parts'. Format: Q30, in (0, 1]. */
int32_t crn_motion_shrink_q30(const crn_motion_steepness *steepness, const crn_motion_moment *now);

/* At or beyond the wall at least 0, else no less than the distance that crn_motion_contact gives there: the
 * lumen's, made smaller by the most that a gradient is lengthened, by `shrink` everywhere or, where the
 * distance is not below `far` by it, here. */
int32_t crn_motion_distance(const crn_lumen *lumen, const crn_motion *motion, crn_motion_pose *pose,
                            const crn_vec3 *world_m_q30, int32_t shrink_q30, int32_t far_m_q30);

/* As crn_lumen_contact of the moved wall: distance phi / |g| (exact at the wall), normal -g / |g|. */
crn_lumen_sample crn_motion_contact(const crn_lumen *lumen, const crn_motion *motion, crn_motion_pose *pose,
                                    const crn_vec3 *world_m_q30);
/* The same at the place of the last crn_motion_distance. */
crn_lumen_sample crn_motion_contact_here(const crn_lumen *lumen, const crn_motion *motion,
                                         crn_motion_pose *pose);

/* A sample of the wall at the place of the last crn_motion_pull, in the reference pose, as it is in the
 * world. */
crn_lumen_sample crn_motion_carry(const crn_motion *motion, crn_motion_pose *pose, crn_lumen_sample sample);

/* Way of the wall in this tick at the place of the last contact. Format: Q33 m, limited to
 * CRN_MOTION_WALL_STEP_MAX. */
crn_vec3 crn_motion_wall_step(const crn_motion *motion, crn_motion_pose *pose);

#endif
