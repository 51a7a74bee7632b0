/* This file computes the displacement of a moving vessel's wall in a tick (motion.h, docs/heart.md). */
#include "firmware/core/motion_cell.h"
#include "firmware/core/rod.h"

enum {
    DETERMINANT_MIN_q20 = 1 << 17
}; /* 1/8: a lattice that folds over is invalid, but must not cause a division by zero */

enum {
    MOST_M_Q34 = 2 * CRN_MOTION_WALL_STEP_MAX_M_Q33,
    /* largest change of a weight in a tick: a quarter of a keyframe, 600 beats a minute */
    FASTEST_Q15 = 1 << 13
};

/* Returns the change of a corner's displacement in a tick that began before a keyframe and ended after this
 * keyframe. */
static int32_t change_across(const int16_t *row, uint32_t step, const crn_motion_pose *pose)
{
    const int32_t change = crn_sub_sat(blend(row + pose->now.first * step, step, &pose->now),
                                       blend(row + pose->before.first * step, step, &pose->before));
    return crn_clamp(change, -MOST_M_Q34, MOST_M_Q34);
}

/* Computes the changes of the displacements at the corners of a lattice cell in this tick. Usually the tick
 * begins and ends between the same two keyframes. In this case, the change of a displacement is the sum of
 * its spline coefficients times the changes of their weights; the changes of the weights sum to zero.
 * Overflow is impossible, because the sum has two products of a number up to 2^15 and a number up to 2^13. */
static void enter_changing_cell(const crn_motion *motion, crn_motion_pose *pose, uint32_t node)
{
    const corner_list fresh = move_on(&motion->beat, node, &pose->changes);
    const crn_motion_moment *now = &pose->now, *before = &pose->before;
    const int32_t low = crn_clamp(now->weights_q15[0] - before->weights_q15[0], -FASTEST_Q15, FASTEST_Q15),
                  high = crn_clamp(now->weights_q15[2] - before->weights_q15[2], -FASTEST_Q15, FASTEST_Q15);
    const uint32_t first = now->first;
    const bool is_across = first != before->first;
    for (uint32_t i = 0; i < fresh.count; i++) {
        const uint32_t corner = fresh.corners[i];
        const node_rows rows = rows_of(motion, node + pose->beat.corner_nodes[corner]);
        const uint32_t step = rows.step;
        const int16_t *row = rows.numbers;
        int32_t *change = pose->changes.corners_m_q34[corner].v;
        for (int k = 0; k < 3; k++, row += rows.apart) {
            const int16_t *taps = row + first * step;
            change[k] = is_across ? change_across(row, step, pose)
                                  : (taps[0] - taps[step]) * low + (taps[2 * step] - taps[step]) * high;
        }
    }
}

/* Interpolates between the values of two corners or of two edges of a lattice cell. Overflow: they are below
 * 2^29. */
static inline int32_t between(int32_t a, int32_t b, int32_t share_q31)
{
    return a + from_q31((int64_t)(b - a) * share_q31);
}

/* Returns the change of the heartbeat's displacement w in this tick at the point that was looked up last,
 * limited to 2 mm. Q39 m. */
static inline crn_vec3 change_here(const crn_motion *motion, crn_motion_pose *pose)
{
    if (pose->changes.node != pose->beat.ways.node) {
        enter_changing_cell(motion, pose, pose->beat.ways.node);
    }
    const crn_vec3 *c = pose->changes.corners_m_q34;
    const int32_t x = pose->beat.powers_q31[1], y = pose->beat.powers_q31[2], z = pose->beat.powers_q31[4];
    crn_vec3 change;
    for (int k = 0; k < 3; k++) {
        const int32_t low = between(between(c[0].v[k], c[1].v[k], x), between(c[2].v[k], c[3].v[k], x), y),
                      high = between(between(c[4].v[k], c[5].v[k], x), between(c[6].v[k], c[7].v[k], x), y);
        change.v[k] = crn_clamp(between(low, high, z), -MOST_M_Q34, MOST_M_Q34) * 32;
    }
    return change;
}

/* Returns the high words of the components of a cross product. Format: Qa x Qb -> Q(a+b-32). Error: 1 LSB. */
static inline crn_vec3 cross_high(const crn_vec3 *a, const crn_vec3 *b)
{
    return crn_vec3_make(crn_mulh_sub(crn_mulh(a->v[1], b->v[2]), a->v[2], b->v[1]),
                         crn_mulh_sub(crn_mulh(a->v[2], b->v[0]), a->v[0], b->v[2]),
                         crn_mulh_sub(crn_mulh(a->v[0], b->v[1]), a->v[1], b->v[0]));
}

/* Solves (I + dw/dx) step = -change for `step` by Cramer's rule, where w is the displacement by the
 * heartbeat. From the matrix columns a, b and c, the code computes the two products b x c and change x a,
 * which contain all four determinants that Cramer's rule needs. Overflow is impossible: a component of a
 * column is at most 2, so b x c is below 2^27 (Q24), the determinant is below 2^26 (Q20), and change x a is
 * below 2^29 (Q35). Before the division, the components of the step are below 2^29 in Q31, which is 250 mm.
 */
static crn_vec3 beating_step(const crn_motion *motion, crn_motion_pose *pose)
{
    const int32_t(*m)[3] = (const int32_t(*)[3])pose->gradient_q28;
    const crn_vec3 a = crn_vec3_make(m[0][0], m[1][0], m[2][0]), b = crn_vec3_make(m[0][1], m[1][1], m[2][1]),
                   c = crn_vec3_make(m[0][2], m[1][2], m[2][2]), change = change_here(motion, pose);
    const crn_vec3 across_q24 = cross_high(&b, &c), around_q35 = cross_high(&change, &a);
    const int32_t determinant_q20 = dot_high(&a, &across_q24);
    const uint32_t size =
        (uint32_t)(determinant_q20 > DETERMINANT_MIN_q20 ? determinant_q20 : DETERMINANT_MIN_q20);
    const crn_vec3 turned_q31 = {
        {dot_high(&change, &across_q24), -dot_high(&around_q35, &c), dot_high(&around_q35, &b)}};
    const unsigned lead = crn_clz32(size) - 1;
    const int64_t inverse = crn_reciprocal_q30(size << lead); /* 2^61 / (size 2^lead) */
    crn_vec3 step;
    for (int i = 0; i < 3; i++) {
        /* Q31 / Q20 -> Q33: 22 bits up */
        const int32_t way = crn_sat32(crn_rshift_round64(-turned_q31.v[i] * inverse, 39 - lead));
        step.v[i] = crn_clamp(way, -CRN_MOTION_WALL_STEP_MAX_M_Q33, CRN_MOTION_WALL_STEP_MAX_M_Q33);
    }
    return step;
}

/* Computes the displacement of the wall by heartbeat and breath together, (I + J)^-1 u, by the series u - J
 * (u - J u), from the step u and the gradient J of the breath displacement. The vector u is the heartbeat's
 * step less the change of breath. The relative error of the result is |J|^3 for the gradient J of the breath
 * displacement: 1/20 for the steepest breath motion that a scene may have, and 0.3 % in the shipped heart.
 * Overflow is impossible: u is at most 4 mm, and the sum of the series is below 6 mm, which is below 2^26 in
 * Q33 m. */
static void step_with_breath(const crn_motion *motion, crn_motion_pose *pose, crn_vec3 *step_m_q33)
{
    enum {
        TERMS = 2,
        MOST_Q15 = 1 << 10 /* no one inhales this fast: 2 mm of 31 mm */
    };
    const int32_t depth_q15 = pose->now.breath_q15,
                  deeper_q15 = crn_clamp(depth_q15 - pose->before.breath_q15, -MOST_Q15, MOST_Q15);
    const crn_vec3 x_q30 = breath_slope(motion, pose, 0), y_q30 = breath_slope(motion, pose, 1),
                   z_q30 = breath_slope(motion, pose, 2);
    crn_vec3 alone;
    for (int k = 0; k < 3; k++) {
        /* Q34 x Q15 -> Q33 */
        alone.v[k] = step_m_q33->v[k] -
                     (int32_t)crn_rshift_round64(crn_product(pose->inhaled_m_q34.v[k], deeper_q15), 16);
    }
    crn_vec3 step = alone;
    for (int term = 0; term < TERMS; term++) {
        const crn_vec3 last = {
            {breathed(step.v[0], depth_q15), breathed(step.v[1], depth_q15), breathed(step.v[2], depth_q15)}};
        for (int k = 0; k < 3; k++) {
            const int32_t high = crn_mulh_add(
                crn_mulh_add(crn_mulh(x_q30.v[k], last.v[0]), y_q30.v[k], last.v[1]), z_q30.v[k], last.v[2]);
            step.v[k] = alone.v[k] - high * 4;
        }
    }
    for (int k = 0; k < 3; k++) {
        step_m_q33->v[k] =
            crn_clamp(step.v[k], -CRN_MOTION_WALL_STEP_MAX_M_Q33, CRN_MOTION_WALL_STEP_MAX_M_Q33);
    }
}

CRN_APART static crn_vec3 step_inside(const crn_motion *motion, crn_motion_pose *pose)
{
    crn_vec3 step = {{0, 0, 0}};
    if (pose->beat.is_inside) {
        step = beating_step(motion, pose);
    }
    if (pose->breath.is_inside) {
        step_with_breath(motion, pose, &step);
    }
    return step;
}

crn_vec3 crn_motion_wall_step(const crn_motion *motion, crn_motion_pose *pose)
{
    return moves_here(pose) ? step_inside(motion, pose) : (crn_vec3){{0, 0, 0}};
}
