/* This header has the code for one cell of a lattice of a moving vessel; the look-up (motion.c) and the
 * wall's step (motion_wall.c) share this code. */
#ifndef CRN_MOTION_CELL_H
#define CRN_MOTION_CELL_H

#include "firmware/core/motion.h"
#include "firmware/core/near/near.h"

/* Code that only a few nodes need stays in a separate function, so that it takes no processor registers when
 * the other nodes are computed. */
#define CRN_APART __attribute__((noinline))

enum {
    NO_CELL = -1,
    FRACTION_BITS = 15,
    NODE = 3 * CRN_MOTION_ROW,
    BREATH_NODE = 3,
    NO_TETRAHEDRON = 8,
};

/* The corners to blend. */
typedef struct corner_list {
    const uint8_t *corners;
    uint32_t count;
} corner_list;

/* Moves on to another cell. If the new cell is next to the previous cell along one axis, the function moves
 * the values of the four shared corners to their new indices. Returns the other corners. */
static inline corner_list move_on(const crn_lattice *lattice, uint32_t to, crn_motion_cell *cell)
{
    /* corners on the low and the high side along x, y, z */
    static const uint8_t sides[6][4] = {{0, 2, 4, 6}, {1, 3, 5, 7}, {0, 1, 4, 5},
                                        {2, 3, 6, 7}, {0, 1, 2, 3}, {4, 5, 6, 7}};
    static const uint8_t all[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    const uint32_t steps[3] = {1, lattice->count_xyz[0], lattice->count_xyz[0] * lattice->count_xyz[1]};
    const uint32_t from = cell->node;
    cell->node = to;
    for (uint32_t axis = 0; from != (uint32_t)NO_CELL && axis < 3; axis++) {
        const uint32_t high = to - from == steps[axis] ? 1u : 0u;
        if (high == 0 && from - to != steps[axis]) {
            continue;
        }
        const uint8_t *shared = sides[2 * axis + high], *places = sides[2 * axis + 1 - high];
        for (int i = 0; i < 4; i++) {
            cell->corners_m_q34[places[i]] = cell->corners_m_q34[shared[i]];
        }
        return (corner_list){shared, 4};
    }
    return (corner_list){all, 8};
}

/* Converts the values at the corners of a lattice cell to polynomial terms, by taking differences along one
 * axis after the other. Overflow is impossible: the values of neighbouring nodes differ by at most 5/8 of a
 * spacing (checked when a scene is loaded), so the last term is at most 5/2 of a spacing, which is below
 * 2^30. */
static inline void make_terms(crn_motion_field *field)
{
    const crn_vec3 *c = field->ways.corners_m_q34;
    for (int k = 0; k < 3; k++) {
        int32_t *terms = field->terms_m_q34[k];
        const int32_t x00 = c[1].v[k] - c[0].v[k], x10 = c[3].v[k] - c[2].v[k], x01 = c[5].v[k] - c[4].v[k],
                      x11 = c[7].v[k] - c[6].v[k];
        const int32_t y0 = c[2].v[k] - c[0].v[k], y1 = c[6].v[k] - c[4].v[k];
        terms[0] = c[0].v[k];
        terms[1] = x00;
        terms[2] = y0;
        terms[3] = x10 - x00;
        terms[4] = c[4].v[k] - c[0].v[k];
        terms[5] = x01 - x00;
        terms[6] = y1 - y0;
        terms[7] = x11 - x01 - (x10 - x00);
    }
}

/* Returns the weighted sum of three coefficients of one displacement component. Format: Q15 x 2^-19 m -> Q34
 * m. Overflow is impossible: coefficients are at most 2^14 in magnitude (checked when a scene is loaded) and
 * the weights sum to 2^15, so the result is at most 2^29. */
static inline int32_t blend(const int16_t *taps, uint32_t step, const crn_motion_moment *weights)
{
    return taps[0] * weights->weights_q15[0] + taps[step] * weights->weights_q15[1] +
           taps[2 * step] * weights->weights_q15[2];
}

/* The coefficients of a lattice node: `step` from one keyframe to the next, `apart` from one component to the
 * next. In the scene, a component has its keyframes together; in near memory, a keyframe has its components
 * together, so that the nine numbers of a tick lie in one or two lines of the cache. */
typedef struct node_rows {
    const int16_t *numbers;
    uint32_t step, apart;
} node_rows;

static inline node_rows rows_of(const crn_motion *motion, uint32_t node)
{
    if (motion->near != NULL) {
        return (node_rows){crn_near_rows(motion->near, node), CRN_NEAR_COMPONENTS, 1};
    }
    return (node_rows){motion->rows + (size_t)node * NODE, 1, CRN_MOTION_ROW};
}

/* Format: coefficients of 2^-19 m -> Q34 m. Overflow: 2^14 (checked) x 2^15. */
static inline void enter_breathing_cell(const crn_motion *motion, crn_motion_field *field, uint32_t node)
{
    const corner_list fresh = move_on(&motion->breath, node, &field->ways);
    const int16_t *low = motion->inhaled + (size_t)node * BREATH_NODE;
    for (uint32_t i = 0; i < fresh.count; i++) {
        const uint32_t corner = fresh.corners[i];
        const int16_t *inhaled = low + (size_t)field->corner_nodes[corner] * BREATH_NODE;
        for (int k = 0; k < 3; k++) {
            field->ways.corners_m_q34[corner].v[k] = inhaled[k] * (1 << FRACTION_BITS);
        }
    }
}

/* Returns the fraction `part_q15` of a value that is given for a full breath. Format: that of `full`. Error:
 * 1/2 LSB. Overflow is impossible, because the fraction is at most 1 = 2^15. */
static inline int32_t breathed(int32_t full, int32_t part_q15)
{
    return (int32_t)crn_rshift_round64(crn_product(full, part_q15), FRACTION_BITS);
}

/* Drops the 31 additional fraction bits of a sum, which rounds it down. Error: 1 LSB (floor). */
static inline int32_t from_q31(int64_t sum)
{
    return (int32_t)(uint32_t)((uint64_t)sum >> 31);
}

/* Evaluates a lattice cell's polynomial at the point that was looked up last. Format: that of the terms.
 * Overflow is impossible: the polynomial's terms are at most 3 x 5/8, 3 x 5/4 and 5/2 of a spacing of at most
 * 2^28, and powers are below 2^31, so sums stay below 8.2 x 2^59. The polynomial's value lies between the
 * values at the corners of the lattice cell.
 */
static inline int32_t value_here(const int32_t *terms, const int32_t *powers_q31)
{
    const int32_t *t = terms, *p = powers_q31;
    return t[0] + from_q31((int64_t)t[1] * p[1] + (int64_t)t[2] * p[2] + (int64_t)t[3] * p[3] +
                           (int64_t)t[4] * p[4] + (int64_t)t[5] * p[5] + (int64_t)t[6] * p[6] +
                           (int64_t)t[7] * p[7]);
}

/* Computes the linear function in a tetrahedron of a lattice cell, from one difference along each axis.
 * Overflow is impossible, because the values of neighbouring nodes differ by at most 3/8 of a spacing
 * (checked when a scene is loaded). */
static inline void make_plane(crn_motion_field *field, uint32_t tetrahedron)
{
    /* corners on the path from 0 to 7; two of the eight orders are impossible */
    static const uint8_t ways[8][2] = {{4, 6}, {4, 6}, {2, 6}, {2, 3}, {4, 5}, {1, 5}, {2, 3}, {1, 3}};
    const uint32_t first = ways[tetrahedron][0], second = ways[tetrahedron][1];
    const crn_vec3 *c = field->ways.corners_m_q34;
    for (int k = 0; k < 3; k++) {
        int32_t *terms = field->terms_m_q34[k];
        terms[0] = c[0].v[k];
        terms[first] = c[first].v[k] - c[0].v[k];
        terms[second - first] = c[second].v[k] - c[first].v[k];
        terms[7 - second] = c[7].v[k] - c[second].v[k];
    }
}

static inline int32_t plane_here(const int32_t *t, const int32_t *p_q31)
{
    return t[0] + from_q31((int64_t)t[1] * p_q31[1] + (int64_t)t[2] * p_q31[2] + (int64_t)t[4] * p_q31[4]);
}

static inline bool moves_here(const crn_motion_pose *pose)
{
    return pose->beat.is_inside || pose->breath.is_inside;
}

/* db_i/dx_j, for a full breath. Format: Q34 m per spacing -> Q30. Overflow: at most 3/8 (checked). */
static inline crn_vec3 breath_slope(const crn_motion *motion, const crn_motion_pose *pose, int j)
{
    const int32_t up = (int32_t)1 << (26 - motion->breath.spacing_log2_q30);
    const int32_t(*t)[8] = (const int32_t(*)[8])pose->breath.terms_m_q34;
    return crn_vec3_make(t[0][1 << j] * up, t[1][1 << j] * up, t[2][1 << j] * up);
}

static inline int32_t dot_high(const crn_vec3 *a, const crn_vec3 *b)
{
    return crn_mulh_add(crn_mulh_add(crn_mulh(a->v[0], b->v[0]), a->v[1], b->v[1]), a->v[2], b->v[2]);
}

#endif
