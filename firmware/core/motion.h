/* This header describes vessels that move. For a point of the moving vessel, the functions of this header
 * find the point's position in the reference pose, in which the lumen is described.
 *
 * Two coarse lattices hold displacements: w for the heartbeat and b for breath. The functions first undo the
 * displacement by breath and then the displacement by the heartbeat, because the chest moves the beating
 * heart with it.
 *
 *     X1 = x + depth b(x),  X = X1 + w(X1)
 *
 * A point in patient coordinates is mapped to its point X of the reference pose by two look-ups without
 * iteration, and the vessel wall is where phi(X) = 0. In a lattice cell, the heartbeat's displacement w is
 * trilinear. The displacement b by breath changes smoothly from place to place. In each of the six tetrahedra
 * of a lattice cell (Kuhn), the displacement b is interpolated linearly, which takes a third of the work of a
 * trilinear look-up. As a function of time, the heartbeat's displacement w is a periodic quadratic B-spline
 * with 24 coefficients (C1). The program that bakes a scene filters the coefficients beforehand, so that the
 * spline passes through the keyframes. Outside a lattice, and on its boundary, the displacements w and b are
 * 0.
 *
 *     gradient of the depth used    g = (I + depth db/dx)^T (I + dw/dx)^T grad phi
 *     step of the wall in a tick    -(I + depth db/dx)^-1 ((I + dw/dx)^-1 (w now - w before)
 *                                                          + (depth now - depth before) b)
 *
 * The document docs/heart.md has the equations and their cost. The code in shared/scene checks the data
 * before use, because they may come from an attacker. */
#ifndef CRN_MOTION_H
#define CRN_MOTION_H

#include "firmware/core/lumen.h"
#include "firmware/core/rhythm.h"

enum {
    CRN_MOTION_KEYFRAMES = 24,
    CRN_MOTION_ROW = 26,                      /* numbers of one component of one node of the beat */
    CRN_MOTION_UNIT_LOG2_Q30 = 11,            /* unit of a coefficient: 2^11 / 2^30 m = 1.9 um */
    CRN_MOTION_COEFFICIENT_MAX = 1 << 14,     /* 31 mm */
    CRN_MOTION_SPACING_LOG2_MIN = 20,         /* 0.98 mm */
    CRN_MOTION_SPACING_LOG2_MAX = 24,         /* 15.6 mm */
    CRN_MOTION_WALL_STEP_MAX_M_Q33 = 1 << 24, /* 2 mm in a tick: no wall in a body moves this fast */
};

typedef struct crn_lattice {
    int32_t origin_m_q30[3]; /* node (0,0,0) */
    uint32_t count_xyz[3];   /* nodes along each axis, at least 2 */
    uint32_t spacing_log2_q30;
} crn_lattice;

typedef struct crn_motion {
    crn_lattice beat;
    /* The rows of coefficients are stored node by node, x fastest, with three components for each node. Each
     * component of a node has the coefficients of the keyframes 23, 0, 1 .. 23, 0 in this order. The
     * displacements of neighbouring nodes differ by at most 5/8 of the lattice spacing. */
    const int16_t *rows;
    crn_lattice breath;
    /* The displacements b are stored node by node, x fastest, with three components for each node. The
     * displacements of neighbouring nodes differ by at most 3/8 of the lattice spacing. The pointer `inhaled`
     * is NULL if breath does not move the vessel. */
    const int16_t *inhaled;
    /* Copies of rows in faster memory (near.h), or NULL: rows are read in place. */
    struct crn_near *near;
} crn_motion;

/* Describes heart and breath at one moment: which three coefficients of a row to blend, and with which
 * weights. */
typedef struct crn_motion_moment {
    uint32_t first; /* in a row, 0 .. 23 */
    int32_t weights_q15[3];
    int32_t breath_q15;
} crn_motion_moment;

/* Keeps the blended displacements of a lattice cell's corners for the next point in the cell or in a
 * neighbouring cell. */
typedef struct crn_motion_cell {
    uint32_t node; /* its low node; UINT32_MAX: none */
    crn_vec3 corners_m_q34[8];
} crn_motion_cell;

/* Keeps the values that were derived from one lattice for the point that was looked up last. */
typedef struct crn_motion_field {
    uint32_t corner_nodes[8]; /* nodes from a cell's low node to its corners */
    crn_motion_cell ways; /* displacements from the corners back to the reference pose; for breath: those of a
                             full breath */
    /* The same displacements as polynomials. For the heartbeat, the eight coefficients of a lattice cell's
     * polynomial belong to the terms 1, x, y, xy, z, xz, yz and xyz. For breath, the polynomial's
     * coefficients 0, 1, 2 and 4 belong to the terms 1, x, y and z in the tetrahedron of the point looked up
     * last, and the other coefficients are not used. */
    int32_t terms_m_q34[3][8];
    int32_t low_m_q30[3];  /* position of the cell's low node */
    int32_t powers_q31[8]; /* x, y, xy, z, xz, yz, xyz of the last point pulled back, from [1] on */
    uint32_t tetrahedron;  /* for breath: which tetrahedron of the cell */
    int32_t shrink_q30;    /* for breath there; 0: not computed */
    bool is_inside;        /* the point lay in the lattice */
} crn_motion_field;

/* Holds the phases of heart and breath at the beginning and the end of a tick, and the values that were last
 * derived from the lattices for these two moments. Successive nodes of a wire usually lie in the same lattice
 * cell, so the derived values are used again for the next node. */
typedef struct crn_motion_pose {
    crn_motion_moment now, before;
    crn_motion_field beat, breath;
    crn_motion_cell changes; /* changes of the beat's displacements in the tick */
    crn_vec3 inhaled_m_q34;  /* b at the last point */
    int32_t low_m_q30[3];    /* a box around both lattices: nothing moves beyond it */
    uint32_t size_m_q30[3];
    /* The field reference_m_q30 is the position in the reference pose to which the last call of
     * crn_motion_distance or crn_motion_contact mapped its point. */
    crn_vec3 reference_m_q30;
    int32_t gradient_q28[3][3]; /* I + dw_i/dx_j there, once it has_gradient */
    bool has_gradient;
} crn_motion_pose;

crn_motion_moment crn_motion_moment_at(uint32_t heart_phase32, uint32_t breath_phase32);

/* Begins a tick, in which heart and breath go from the moment `before` to the moment `now`. */
void crn_motion_pose_begin(const crn_motion *motion, crn_motion_pose *pose, const crn_rhythm *before,
                           const crn_rhythm *now);

/* Returns how many bytes of near memory (near/near.h) a lumen with its motion and lesions needs at least;
 * reads the whole index, so it is for set-up only. */
uint32_t crn_lumen_near_bytes(const crn_lumen *lumen);

/* Lets the core read a lumen, its motion and its lesions in near memory, from now on. `motion` and `lesions`
 * are those to which the lumen leads, or NULL. For the memory, see crn_near_begin(). */
void crn_lumen_near_begin(crn_lumen *lumen, crn_motion *motion, crn_lesion *lesions, void *memory,
                          uint32_t bytes);

/* Returns the position in the reference pose of the point that is now at `world_m_q30`. Format: Q30 m.
 * Overflow: saturates. Compared with the exact spline of the stored coefficients, the position has an error
 * of 1 um, caused by weights of 15 bits (firmware/tests/test_motion.c). */
crn_vec3 crn_motion_pull(const crn_motion *motion, crn_motion_pose *pose, const crn_vec3 *world_m_q30);

/* Holds upper bounds of the steepness |J| that a motion has at any place, for each coefficient in a row and
 * for a full breath. The square of |J| is at most a sum over the three axes; each axis adds the square of the
 * largest difference of neighbouring nodes along this axis. Format: Q28, at most 1.1. */
typedef struct crn_motion_steepness {
    int32_t beat_q28[CRN_MOTION_ROW];
    int32_t breath_q28;
} crn_motion_steepness;

/* The function crn_motion_steepness_make reads all of the lattices, so it is for set-up only. */
void crn_motion_steepness_make(const crn_motion *motion, crn_motion_steepness *steepness);

/* The reciprocal of a bound on how much the motion lengthens a gradient at a moment: |(I + J)^T n| <= 1 + |J|
 * for each of the two factors, and |J| of a blend is at most the blend of its parts' |J|. Format: Q30, in (0,
 * 1]. */
int32_t crn_motion_shrink_q30(const crn_motion_steepness *steepness, const crn_motion_moment *now);

/* Returns a lower bound of the distance that crn_motion_contact gives at the same point; at the wall or
 * beyond the wall, this bound is at least 0. Inside the lumen, the bound is the distance in the reference
 * pose, divided by the largest factor by which the motion can increase a gradient. The motion increases a
 * gradient at most by a certain factor; `shrink_q30` is the reciprocal of a limit of this factor that is
 * valid at every point. If the general limit from `shrink_q30` gives a distance of `far_m_q30` or more, the
 * function uses the more exact limit at the given point instead. */
int32_t crn_motion_distance(const crn_lumen *lumen, const crn_motion *motion, crn_motion_pose *pose,
                            const crn_vec3 *world_m_q30, int32_t shrink_q30, int32_t far_m_q30);

/* Like crn_lumen_contact for the moved wall: distance phi / |g| (exact at the wall), normal -g / |g|. */
crn_lumen_sample crn_motion_contact(const crn_lumen *lumen, const crn_motion *motion, crn_motion_pose *pose,
                                    const crn_vec3 *world_m_q30);
/* Samples the moved wall as crn_motion_contact does, at the point of the last call of crn_motion_distance. */
crn_lumen_sample crn_motion_contact_here(const crn_lumen *lumen, const crn_motion *motion,
                                         crn_motion_pose *pose);

/* Converts a sample of the vessel wall from the reference pose to patient coordinates, at the point of the
 * last call of crn_motion_pull. */
crn_lumen_sample crn_motion_carry(const crn_motion *motion, crn_motion_pose *pose, crn_lumen_sample sample);

/* Returns the displacement of the vessel wall in this tick at the point of the last contact. Format: Q33 m,
 * limited to CRN_MOTION_WALL_STEP_MAX. */
crn_vec3 crn_motion_wall_step(const crn_motion *motion, crn_motion_pose *pose);

#endif
