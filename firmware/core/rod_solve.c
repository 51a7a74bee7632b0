/* This file solves the implicit step A delta = r for the nodes' deviations delta by block LDL^T, from tip to
 * base. The blocks of the matrix are 3x3, and each row has two blocks to the right of its diagonal block.
 *
 *   A[i][i] = D = R + S,  A[i][i+1] = Q - S,  A[i][i+2] = kb I
 *
 * The two nodes na and na+1, which the introducer sheath holds, do not deviate from the slide (delta = 0). In
 * the diagonal block of a node, S is the stiffness of the edge behind the node, and R is the stiffness of
 * everything else that acts on the node. The elimination uses the blocks T = R + Q, V = D^-1 T (so that D^-1
 * (Q - S) is V - I), and P = kb D^-1, where D = R + S is the diagonal block, and Q - S and kb I are the two
 * blocks to its right.
 *
 *   R[i+1] += R + Q + Q^T - T^T V     R[i+2] -= kb P      Q[i+1] += kb (I - V^T)
 *   r[i+1] += r - V^T r               r[i+2] -= P r
 *   back: delta[i] = D^-1 r[i] + delta[i+1] - V delta[i+1] - P delta[i+2]
 *
 * The blocks are chosen so that terms as large as S do not cancel each other, and so that the bending pattern
 * 1, -2, 1 of a free rod is exact from the tip on. The solve needs one reciprocal by Newton's method for each
 * node and no division. Each row of the matrix adds the contributions of the two rows before it, so that a
 * sum of up to six products is rounded once and no intermediate result is stored. Factors have 32 bits and
 * sums have 64 bits, so each product takes one SMLAL instruction on the Cortex-M7. The number formats are
 * Q(a) N/m below 2^29 for D, R, S, Q, T and kb, Q29 for V and P, Q22 N for r, and Q33 m for delta. */
#include "firmware/core/rod_block.h"

/* --- a row, in C --- */

/* Returns one component of the right side r + r' - V'^T r' - P'' r'', limited to 256 newtons. Overflow is
 * impossible: forces are within 2^30, and the magnitudes of a row of V^T and of a row of P add up to less
 * than 2^31 and 2^30, so sums stay below 2^62. */
static inline int32_t gather_force(const crn_row *row, int k, int32_t p0, int32_t p1, int32_t p2)
{
    const int32_t *v = row->last->w_q29 + k;
    const int32_t *r = row->r, *before = row->r_before;
    int64_t sum = (int64_t)v[0] * r[0] + (int64_t)v[3] * r[1] + (int64_t)v[6] * r[2] +
                  (int64_t)p0 * before[0] + (int64_t)p1 * before[1] + (int64_t)p2 * before[2] + (1 << 28);
    return limit((int64_t)row->force_N_q22->v[k] + r[k] - (sum >> 29), FORCE_MAX_N_Q22);
}

/* z = D^-1 r. Format: r Q22 N -> Q33 m: shift = exponent - a - 11. Overflow is impossible, because the sum is
 * at most 3 * 2^29 * 2^30. */
static inline void apply(const crn_row *row, const int32_t *r)
{
    const int32_t *n = row->inverse;
    const unsigned shift = row->exponent - row->force_exponent;
    int32_t *z = row->solution_m_q33->v;
    z[0] = deviation_of((int64_t)n[XX] * r[0] + (int64_t)n[XY] * r[1] + (int64_t)n[XZ] * r[2], shift);
    z[1] = deviation_of((int64_t)n[XY] * r[0] + (int64_t)n[YY] * r[1] + (int64_t)n[YZ] * r[2], shift);
    z[2] = deviation_of((int64_t)n[XZ] * r[0] + (int64_t)n[YZ] * r[1] + (int64_t)n[ZZ] * r[2], shift);
}

bool crn_row_any_force(crn_row *row)
{
    const int32_t *p = row->p_before->m;
    const int32_t r[3] = {gather_force(row, 0, p[XX], p[XY], p[XZ]),
                          gather_force(row, 1, p[XY], p[YY], p[YZ]),
                          gather_force(row, 2, p[XZ], p[YZ], p[ZZ])};
    apply(row, r);
    bool limited = false;
    for (int k = 0; k < 3; k++) {
        limited |= r[k] >= FORCE_MAX_N_Q22 || r[k] <= -FORCE_MAX_N_Q22;
        row->r_before[k] = row->r[k];
        row->r[k] = r[k];
    }
    return limited;
}

#if !CRN_ROW_BY_ASSEMBLY

/* Adds the stiffness of a touching node, k_n n n^T + k_f (I - n n^T) + k_r (I - n n^T - t' t'^T), where n is
 * the wall's normal, t' is the tangent across n, k_n and k_f are the stiffnesses of contact and friction, and
 * k_r is that of the round wall. A step across the normal n and the tangent t' turns the direction of the
 * normal force, because the wall is round. Without the stiffness k_r = N / r (normal force over an assumed
 * radius of 1 mm), a step across the normal would oscillate for ever where there is no friction (docs/rod.md,
 * "contact"). With b = n x t and c = n.t, for the wall's normal n and the tool's tangent t, the bracket I - n
 * n^T - t' t'^T is b b^T + c^2 (I - n n^T). If a tip touches the wall head on, there is no tangent t' across
 * n, and k_r then acts in all directions across n. */
static inline void add_wall(const crn_work *work, const crn_vec3 *tangent, crn_sym3 *d)
{
    const crn_vec3 *n = &work->normal_q30;
    int32_t across = work->wall_friction;
    if (work->touching && work->wall_round != 0) {
        int32_t inwards = crn_vec3_dot_unit(tangent, n);
        add_along(&work->around_q30, work->wall_round, d);
        across += crn_scale_q30(crn_scale_q30(work->wall_round, inwards), inwards);
    }
    d->m[XX] += across;
    d->m[YY] += across;
    d->m[ZZ] += across;
    add_along(n, work->wall_normal - across, d);
}

/* Returns one entry of the matrix T'^T V' + kb'' P'', which the elimination subtracts from a diagonal block.
 * Overflow is impossible, because the sum is at most 3 * 2^29 * 2^31 + 2^27 * 2^31 < 2^62. */
static inline int32_t taken(const int32_t *t, const int32_t *v_q29, int32_t second, int32_t p_q29)
{
    int64_t sum = (int64_t)t[0] * v_q29[0] + (int64_t)t[1] * v_q29[1] + (int64_t)t[2] * v_q29[2] +
                  (int64_t)second * p_q29 + (1 << 28);
    return crn_narrow64(sum, 29);
}

/* R += R' + Q' + Q'^T - T'^T V' - kb'' P'' */
static inline void gather_rest(crn_row *row, crn_sym3 *rest)
{
    static const uint8_t rows[6] = {0, 0, 0, 1, 1, 2}, columns[6] = {0, 1, 2, 1, 2, 2};
    for (int k = 0; k < 6; k++) {
        rest->m[k] = row->rest.m[k] - taken(row->t + 3 * rows[k], row->v_q29 + 3 * columns[k],
                                            row->second_before, row->p_before->m[k]);
    }
}

/* Computes the block Q = next I + kb' (I - V'^T) of a row, by columns. Overflow is impossible: kb is below
 * 2^27, because a diagonal entry holds W (a + c)^2 >= 4 kb, so 8 kb fits. */
static inline void gather_upper(const crn_row *row, int32_t *q)
{
    for (int k = 0; k < 9; k++) {
        q[k] = crn_mulh_add(k % 4 == 0 ? row->diagonal : 0, row->minus_second8, row->last->w_q29[k]);
    }
}

/* T = R + Q, and R + Q + Q^T for the next row. */
static inline void give(crn_row *row, const crn_sym3 *rest, const int32_t *q)
{
    const int32_t *m = rest->m;
    int32_t *t = row->t;
    const int32_t whole[9] = {m[XX], m[XY], m[XZ], m[XY], m[YY], m[YZ], m[XZ], m[YZ], m[ZZ]};
    for (int k = 0; k < 9; k++) {
        t[k] = whole[k] + q[k];
    }
    const int32_t next[6] = {t[0] + q[0], t[1] + q[3], t[2] + q[6], t[4] + q[4], t[5] + q[7], t[8] + q[8]};
    for (int k = 0; k < 6; k++) {
        row->rest.m[k] = next[k];
    }
}

/* Computes the block V = D^-1 T in Q29 from the inverse of the diagonal block D. Overflow is impossible: a
 * sum is at most 3 * 2^29 * 2^29, and |W| = |V - I| is at most 2 for meshes whose elements grow towards the
 * base. */
static inline void times(crn_row *row)
{
    const int32_t *n = row->inverse;
    const int32_t whole[9] = {n[XX], n[XY], n[XZ], n[XY], n[YY], n[YZ], n[XZ], n[YZ], n[ZZ]};
    const unsigned shift = row->exponent - 29; /* 1 .. 30 */
    for (int c = 0; c < 3; c++) {
        const int32_t *t = row->t + 3 * c;
        for (int i = 0; i < 3; i++) {
            const int32_t *of = whole + 3 * i;
            const int64_t sum = (int64_t)of[0] * t[0] + (int64_t)of[1] * t[1] + (int64_t)of[2] * t[2];
            row->factor->w_q29[3 * i + c] = row->v_q29[3 * c + i] = crn_narrow64(sum, shift);
        }
    }
}

/* Computes the block P = kb D^-1 in Q29, from the inverse of the diagonal block D. Overflow is impossible: P
 * is at most 1, because kb is at most the smallest eigenvalue of D. */
static inline void second_neighbour(const crn_row *row)
{
    for (int k = 0; k < 6; k++) {
        row->factor->p_q29.m[k] = crn_narrow64((int64_t)row->inverse[k] * row->second, row->exponent - 29);
    }
}

void crn_row_factor(crn_row *row)
{
    crn_sym3 d;
    int32_t q[9];
    if (row->wall != NULL) {
        add_wall(row->wall, row->tangent_q30, &row->rest);
    }
    gather_rest(row, &d);
    gather_upper(row, q);
    give(row, &d, q);
    d.m[XX] += row->geometric;
    d.m[YY] += row->geometric;
    d.m[ZZ] += row->geometric;
    add_along4(row->tangent_q30, row->spring4, &d);
    inverse3 inverse;
    invert(&d, &inverse);
    for (int k = 0; k < 6; k++) {
        row->inverse[k] = (int32_t)inverse.m[k];
    }
    row->exponent = inverse.exponent;
    times(row);
    second_neighbour(row);
}

#endif

/* --- the matrix -------------------------------------------------------------------------------------------
 */

/* Writes what the elimination of row i needs beside the rows before it. The assembled forces stay unchanged,
 * so that a second solve can start from these forces. */
static inline void load_row(const crn_model *model, crn_state *state, uint32_t i, const joints3 *joint,
                            crn_row *row)
{
    crn_work *work = &state->scratch.nodes[i];
    row->factor = &work->u.f;
    row->force_N_q22 = &work->force_N_q22;
    row->solution_m_q33 = &work->solution_m_q33;
    row->tangent_q30 = &state->words.nodes[i].tangent_q30;
    row->geometric = work->geometric;
    row->spring4 = 4 * (state->line.nodes[i].spring - work->geometric);
    row->minus_second8 = -8 * row->second;
    row->diagonal = row->second - (joint->here->q + joint->here->r + joint->after->p + joint->after->q);
    row->second = joint->after->q;
    const int32_t own = diagonal_of(model, state, i, joint);
    row->rest.m[XX] += own;
    row->rest.m[YY] += own;
    row->rest.m[ZZ] += own;
    row->wall = (work->wall_normal | work->wall_friction) != 0 ? work : NULL;
    if (work->touching > 1) {
        const crn_second_contact *second = &state->scratch.second[work->touching - 2];
        add_along(&second->normal_q30, second->stiffness, &row->rest);
    }
}

/* Eliminates all rows of the matrix in one pass from tip to base. */
static void eliminate(const crn_model *model, crn_state *state)
{
    static const crn_factor none = {{0}, {{0}}};
    static const crn_joint no_joint = {0};
    crn_row row = {.last = &none, .p_before = &none.p_q29, .force_exponent = model->stiffness_exponent + 11u};
    joints3 joint = {NULL, &no_joint, crn_rod_joint(state, 0)};
    bool limited = false;
    for (uint32_t i = 0; i < state->words.free_count; i++) {
        joint = (joints3){joint.here, joint.after, crn_rod_joint(state, i + 1)};
        const int32_t second_last = row.second;
        load_row(model, state, i, &joint, &row);
        crn_row_factor(&row);
        limited |= crn_row_force(&row);
        row.second_before = second_last;
        row.p_before = &row.last->p_q29;
        row.last = row.factor;
    }
    if (limited) {
        state->words.fault_bits |= CRN_FAULT_SATURATED;
    }
}

/* Back substitution for the components `first` .. 2 of a node. Format: Q29 x Q33 -> Q33. Overflow is
 * impossible: displacements are limited to 62 mm, so the sums stay below 2^62. */
static inline void substitute_node(crn_work *here, int first)
{
    const int32_t *w = here->u.f.w_q29;
    const int32_t *p = here->u.f.p_q29.m;
    const int32_t *b = here[1].solution_m_q33.v;
    const int32_t *c = here[2].solution_m_q33.v;
    const int32_t pr[9] = {p[XX], p[XY], p[XZ], p[XY], p[YY], p[YZ], p[XZ], p[YZ], p[ZZ]};
    for (int k = first; k < 3; k++) {
        int64_t sum = (int64_t)w[3 * k] * b[0] + (int64_t)w[3 * k + 1] * b[1] + (int64_t)w[3 * k + 2] * b[2];
        sum += (int64_t)pr[3 * k] * c[0] + (int64_t)pr[3 * k + 1] * c[1] + (int64_t)pr[3 * k + 2] * c[2];
        int64_t value = (int64_t)here->solution_m_q33.v[k] + b[k] - crn_rshift_round64(sum, 29);
        here->solution_m_q33.v[k] = limit(value, SOLUTION_MAX_M_Q33);
    }
}

void crn_rod_substitute(crn_state *state)
{
    uint32_t na = state->words.free_count;
    crn_work *work = state->scratch.nodes;
    work[na].solution_m_q33 = (crn_vec3){{0, 0, 0}};
    work[na + 1].solution_m_q33 = (crn_vec3){{0, 0, 0}};
    for (uint32_t n = na; n > 0; n--) {
        int first = 0;
#if CRN_ROW_BY_ASSEMBLY
        uint32_t saved[9];
        const uint32_t left = crn_row_substitute(&work[n - 1], n, saved);
        if (left == 0) {
            return;
        }
        n = left / 4;
        first = (int)(left % 4);
#endif
        substitute_node(&work[n - 1], first);
    }
}

void crn_rod_solve(const crn_model *model, crn_state *state)
{
#if CRN_HAS_LANES
    if (model->has_lanes) {
        if (crn_rod_eliminate_lanes(model, state)) {
            state->words.fault_bits |= CRN_FAULT_SATURATED;
        }
        crn_rod_substitute(state);
        return;
    }
#endif
    eliminate(model, state);
    crn_rod_substitute(state);
}

/* Returns the axial force of the tools on the two nodes that the introducer sheath holds, computed from f - A
 * delta. The force includes bending. The force of the edge alone jumps when a node is freed, and is too low
 * when the tools are bent at the sheath's distal end (docs/rod.md). */
int32_t crn_rod_handle_axial(const crn_model *model, const crn_state *state)
{
    uint32_t na = state->words.free_count;
    const crn_work *work = state->scratch.nodes;
    crn_sym3 spring = {{0}};
    add_edge(state, na - 1, &spring);
    const int32_t *s = spring.m;
    const crn_joint *last = &state->scratch.mouth[0]; /* joints na-1 and na */
    const crn_joint *held = &state->scratch.mouth[1];
    int64_t off = -(last->q + last->r + held->p + held->q);
    const int64_t row[9] = {off - s[XX], -s[XY], -s[XZ], -s[XY],     off - s[YY],
                            -s[YZ],      -s[XZ], -s[YZ], off - s[ZZ]};
    const int32_t *near = work[na - 1].solution_m_q33.v;
    const int32_t *far = work[na - 2].solution_m_q33.v;
    unsigned shift = model->stiffness_exponent + 11;
    int64_t axial = 0;
    for (int k = 0; k < 3; k++) {
        int64_t moved = row[3 * k] * near[0] + row[3 * k + 1] * near[1] + row[3 * k + 2] * near[2];
        moved += (int64_t)last->q * far[k] + (int64_t)held->q * near[k];
        int64_t force = (int64_t)work[na].force_N_q22.v[k] + work[na + 1].force_N_q22.v[k];
        force -= crn_rshift_round64(moved, shift);
        axial -= force * model->entry.direction_q30.v[k];
    }
    return crn_sat32(crn_rshift_round64(axial, 30));
}
