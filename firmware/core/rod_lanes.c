/* This file eliminates the rows of rod_solve.c on a processor that computes a row of a block in one step
 * (lanes.h). Equations, number formats, bounds and every rounding are those of rod_solve.c.
 *
 * A block is three rows, each in one register. The right side r is the fourth column of T, because V = D^-1 T
 * and D^-1 r, and likewise T^T V and r^T V, are then one product of blocks. The inverse of D is computed
 * without lanes. */
#include "firmware/core/lanes.h"
#include "firmware/core/rod_block.h"

#if CRN_HAS_LANES

/* Holds what an eliminated row gives to the next two rows. */
typedef struct lanes_row {
    crn_lanes t[3];   /* rows of T; the fourth lane is r */
    crn_lanes t_r[4]; /* columns of T, and r */
    crn_lanes q[3];   /* columns of Q */
    crn_lanes v[3], p[3];
    crn_lanes second;
} lanes_row;

/* Adds k v v^T, as add_along() does; `v_q30` holds the vector. */
CRN_LANES_INLINE void lanes_add_along(crn_lanes v_q30, int32_t stiffness, crn_lanes rows[3])
{
    const crn_lanes part = crn_lanes_mulh(crn_lanes_all(4 * stiffness), v_q30);
    const crn_lanes scaled = (crn_lanes)((crn_lanes_u64)part << 2);
    rows[0] += crn_lanes_mulh(__builtin_shufflevector(scaled, scaled, 0, 0, 0, 0), v_q30);
    rows[1] += crn_lanes_mulh(__builtin_shufflevector(scaled, scaled, 1, 1, 1, 1), v_q30);
    rows[2] += crn_lanes_mulh(__builtin_shufflevector(scaled, scaled, 2, 2, 2, 2), v_q30);
}

/* Adds a multiple of the unit matrix. */
CRN_LANES_INLINE void lanes_add_diagonal(int32_t value, crn_lanes rows[3])
{
    const crn_lanes all = crn_lanes_all(value), none = crn_lanes_all(0);
    rows[0] += __builtin_shufflevector(none, all, 4, 1, 2, 3);
    rows[1] += __builtin_shufflevector(none, all, 0, 5, 2, 3);
    rows[2] += __builtin_shufflevector(none, all, 0, 1, 6, 3);
}

/* Adds the stiffness of a touching node, as add_wall() does. */
CRN_LANES_INLINE void lanes_add_wall(const crn_state *state, const crn_work *work, const crn_vec3 *tangent,
                                     crn_lanes rows[3])
{
    int32_t across = work->wall_friction;
    if (work->touching && work->wall_round != 0) {
        const int32_t inwards = crn_vec3_dot_unit(tangent, &work->normal_q30);
        lanes_add_along(crn_lanes_read(work->around_q30.v), work->wall_round, rows);
        across += crn_scale_q30(crn_scale_q30(work->wall_round, inwards), inwards);
    }
    lanes_add_diagonal(across, rows);
    lanes_add_along(crn_lanes_read(work->normal_q30.v), work->wall_normal - across, rows);
    if (work->touching > 1) {
        const crn_second_contact *second = &state->scratch.second[work->touching - 2];
        const crn_vec3 *n = &second->normal_q30;
        lanes_add_along((crn_lanes){n->v[0], n->v[1], n->v[2], 0}, second->stiffness, rows);
    }
}

/* Adds R' + Q' + Q'^T - T'^T V' - kb'' P'' to the rows of R. The entries below the diagonal have no meaning.
 */
CRN_LANES_INLINE void lanes_gather_rest(const lanes_row *last, const lanes_row *before, crn_lanes rows[3])
{
    for (int i = 0; i < 3; i++) {
        crn_lanes sum = crn_lanes_product(before->second, before->p[i]) + crn_lanes_all(1 << 28);
        for (int k = 0; k < 3; k++) {
            sum += crn_lanes_product(crn_lanes_all(last->t_r[i][k]), last->v[k]);
        }
        rows[i] += last->t[i] + last->q[i] - crn_lanes_shift(sum, 29);
    }
}

/* Returns r + r' - V'^T r' - P'' r'', limited to 256 newtons, with its sign. Lanes of *limited become -1
 * where the force reached the limit. */
CRN_LANES_INLINE crn_lanes lanes_gather_force(const crn_vec3 *force_N_q22, const lanes_row *last,
                                              const lanes_row *before, crn_lanes *limited)
{
    crn_lanes sum = crn_lanes_all(1 << 28);
    for (int k = 0; k < 3; k++) {
        sum += crn_lanes_product(crn_lanes_all(last->t_r[3][k]), last->v[k]) +
               crn_lanes_product(crn_lanes_all(before->t_r[3][k]), before->p[k]);
    }
    const crn_lanes force = crn_lanes_read(force_N_q22->v) + last->t_r[3] - crn_lanes_asr(sum, 29);
    const crn_lanes most = crn_lanes_all(FORCE_MAX_N_Q22 - 1);
    *limited |= (force > most) | (-most > force);
    return crn_lanes_clamp(force, FORCE_MAX_N_Q22);
}

/* Computes T = R + Q by columns and by rows. */
CRN_LANES_INLINE void lanes_make_t(const crn_lanes rows[3], crn_lanes force, lanes_row *row)
{
    /* the entries below the diagonal of R */
    const crn_lanes second = __builtin_shufflevector(rows[0], rows[1], 1, 5, 6, 7);
    const crn_lanes upper = __builtin_shufflevector(rows[0], rows[1], 0, 4, 2, 6);
    const crn_lanes third = __builtin_shufflevector(upper, rows[2], 2, 3, 6, 7);
    row->t_r[0] = rows[0] + row->q[0];
    row->t_r[1] = second + row->q[1];
    row->t_r[2] = third + row->q[2];
    row->t_r[3] = force;
    const crn_lanes low01 = __builtin_shufflevector(row->t_r[0], row->t_r[1], 0, 4, 2, 6);
    const crn_lanes high01 = __builtin_shufflevector(row->t_r[0], row->t_r[1], 1, 5, 3, 7);
    const crn_lanes low23 = __builtin_shufflevector(row->t_r[2], force, 0, 4, 2, 6);
    const crn_lanes high23 = __builtin_shufflevector(row->t_r[2], force, 1, 5, 3, 7);
    row->t[0] = __builtin_shufflevector(low01, low23, 0, 1, 4, 5);
    row->t[1] = __builtin_shufflevector(high01, high23, 0, 1, 4, 5);
    row->t[2] = __builtin_shufflevector(low01, low23, 2, 3, 6, 7);
}

/* Writes D^-1 r, limited to 62 mm, from the fourth lanes of the sums of products. Error: 1/2 LSB. */
CRN_LANES_INLINE void lanes_write_deviation(const crn_lanes sums[3], unsigned shift,
                                            crn_vec3 *deviation_m_q33)
{
    const crn_lanes pair = __builtin_shufflevector(sums[0], sums[1], 1, 5, 3, 7);
    const crn_lanes sum = __builtin_shufflevector(pair, sums[2], 2, 3, 7, 7);
    const crn_lanes shifted = crn_lanes_asr(sum + crn_lanes_all((int64_t)1 << (shift - 1)), shift);
    const crn_lanes limited = crn_lanes_clamp(shifted, SOLUTION_MAX_M_Q33);
    crn_lanes_write3(deviation_m_q33->v, limited);
}

/* Computes V, P and D^-1 r from the inverse of D, and stores them for the substitution. */
CRN_LANES_INLINE void lanes_factor(const inverse3 *inverse, int32_t second, unsigned exponent_a,
                                   crn_work *work, lanes_row *row)
{
    const unsigned shift = inverse->exponent - 29;
    const unsigned shift_r = inverse->exponent - exponent_a - 11;
    crn_lanes n[6];
    for (int k = 0; k < 6; k++) {
        n[k] = crn_lanes_all(inverse->m[k]);
    }
    const crn_lanes by_row[3][3] = {{n[XX], n[XY], n[XZ]}, {n[XY], n[YY], n[YZ]}, {n[XZ], n[YZ], n[ZZ]}};
    row->second = crn_lanes_all(second);
    crn_lanes sums[3];
    for (int i = 0; i < 3; i++) {
        sums[i] = crn_lanes_product(by_row[i][0], row->t[0]) + crn_lanes_product(by_row[i][1], row->t[1]) +
                  crn_lanes_product(by_row[i][2], row->t[2]);
        row->v[i] = crn_lanes_shift(sums[i], shift);
        const crn_lanes pair = __builtin_shufflevector(by_row[i][0], by_row[i][1], 0, 5, 2, 7);
        const crn_lanes of_row = __builtin_shufflevector(pair, by_row[i][2], 0, 1, 6, 7);
        row->p[i] = crn_lanes_shift(crn_lanes_product(of_row, row->second), shift);
    }
    lanes_write_deviation(sums, shift_r, &work->solution_m_q33);
    crn_factor *f = &work->u.f;
    crn_lanes_write(f->w_q29, row->v[0]); /* the next write covers the fourth word */
    crn_lanes_write(f->w_q29 + 3, row->v[1]);
    crn_lanes_write3(f->w_q29 + 6, row->v[2]);
    const crn_lanes p[3] = {row->p[0], row->p[1], row->p[2]};
    f->p_q29 = (crn_sym3){{(int32_t)p[0][0], (int32_t)p[0][1], (int32_t)p[0][2], (int32_t)p[1][1],
                           (int32_t)p[1][2], (int32_t)p[2][2]}};
}

/* Eliminates row i, as eliminate_row() does. The inverse of D comes first, because the next row waits for it.
 */
CRN_LANES_INLINE void lanes_row_of(const crn_model *model, crn_state *state, uint32_t i, const joints3 *joint,
                                   const lanes_row *last, const lanes_row *before, lanes_row *row,
                                   crn_lanes *limited)
{
    crn_work *work = &state->scratch.nodes[i];
    const int32_t next = -(joint->here->q + joint->here->r + joint->after->p + joint->after->q);
    const int32_t second = joint->after->q;
    const crn_lanes none = crn_lanes_all(0);
    crn_lanes rows[3] = {none, none, none};
    lanes_add_diagonal(diagonal_of(model, state, i, joint), rows);
    if ((work->wall_normal | work->wall_friction) != 0) {
        lanes_add_wall(state, work, &state->words.nodes[i].tangent_q30, rows);
    }
    lanes_gather_rest(last, before, rows);
    crn_lanes whole[3] = {rows[0], rows[1], rows[2]};
    lanes_add_diagonal(work->geometric, whole);
    lanes_add_along(crn_lanes_read(state->words.nodes[i].tangent_q30.v),
                    state->line.nodes[i].spring - work->geometric, whole);
    const crn_sym3 d = {{(int32_t)whole[0][0], (int32_t)whole[0][1], (int32_t)whole[0][2],
                         (int32_t)whole[1][1], (int32_t)whole[1][2], (int32_t)whole[2][2]}};
    inverse3 inverse;
    invert(&d, &inverse);
    const crn_lanes minus_q3 = -(crn_lanes)((crn_lanes_u64)last->second << 3);
    for (int c = 0; c < 3; c++) {
        row->q[c] = crn_lanes_mulh(minus_q3, last->v[c]);
    }
    lanes_add_diagonal(next + (int32_t)last->second[0], row->q);
    const crn_lanes force = lanes_gather_force(&work->force_N_q22, last, before, limited);
    lanes_make_t(rows, force, row);
    lanes_factor(&inverse, second, model->stiffness_exponent, work, row);
}

CRN_LANES_TARGET bool crn_rod_eliminate_lanes(const crn_model *model, crn_state *state)
{
    static const crn_joint no_joint = {0};
    lanes_row rows[3] = {0};
    crn_lanes limited = crn_lanes_all(0);
    joints3 joint = {NULL, &no_joint, crn_rod_joint(state, 0)};
    lanes_row *last = &rows[0], *before = &rows[1], *row = &rows[2];
    for (uint32_t i = 0; i < state->words.free_count; i++) {
        joint = (joints3){joint.here, joint.after, crn_rod_joint(state, i + 1)};
        lanes_row_of(model, state, i, &joint, last, before, row, &limited);
        lanes_row *oldest = before;
        before = last;
        last = row;
        row = oldest;
    }
    return (limited[0] | limited[1] | limited[2]) != 0;
}

#endif
