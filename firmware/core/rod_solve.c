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

/* One entry of D^-1 T. */
static inline int32_t row_times(int_fast32_t a, int_fast32_t b, int_fast32_t c, const int_fast32_t *t,
                                unsigned shift)
{
    return crn_narrow64((int64_t)a * t[0] + (int64_t)b * t[3] + (int64_t)c * t[6], shift);
}

/* Computes the block V = D^-1 T in Q29, column by column, from the inverse of the diagonal block D. Overflow
 * is impossible: a sum is at most 3 * 2^29 * 2^29, and |W| = |V - I| is at most 2 for meshes whose elements
 * grow towards the base. */
static inline void times(const inverse3 *inverse, const int_fast32_t *t, int32_t *v_q29)
{
    const int_fast32_t *n = inverse->m;
    unsigned shift = inverse->exponent - 29; /* 1 .. 30 */
    for (int c = 0; c < 3; c++) {
        v_q29[c] = row_times(n[XX], n[XY], n[XZ], t + c, shift);
        v_q29[3 + c] = row_times(n[XY], n[YY], n[YZ], t + c, shift);
        v_q29[6 + c] = row_times(n[XZ], n[YZ], n[ZZ], t + c, shift);
    }
}

/* z = D^-1 r. Format: r Q22 N -> Q33 m: shift = exponent - a - 11. Overflow is impossible, because the sum is
 * at most 3 * 2^29 * 2^30. */
static inline void apply(const inverse3 *inverse, const int_fast32_t *r, unsigned exponent_a, crn_vec3 *z)
{
    const int_fast32_t *n = inverse->m;
    unsigned shift = inverse->exponent - exponent_a - 11;
    z->v[0] = deviation_of((int64_t)n[XX] * r[0] + (int64_t)n[XY] * r[1] + (int64_t)n[XZ] * r[2], shift);
    z->v[1] = deviation_of((int64_t)n[XY] * r[0] + (int64_t)n[YY] * r[1] + (int64_t)n[YZ] * r[2], shift);
    z->v[2] = deviation_of((int64_t)n[XZ] * r[0] + (int64_t)n[YZ] * r[1] + (int64_t)n[ZZ] * r[2], shift);
}

/* Computes the block P = kb D^-1 in Q29, from the inverse of the diagonal block D. Overflow is impossible: P
 * is at most 1, because kb is at most the smallest eigenvalue of D. */
static inline void second_neighbour(const inverse3 *inverse, int32_t second, crn_sym3 *p_q29)
{
    unsigned shift = inverse->exponent - 29;
    for (int k = 0; k < 6; k++) {
        p_q29->m[k] = crn_narrow64((int64_t)inverse->m[k] * second, shift);
    }
}

/* Holds what the two previous rows contribute to the next row of the matrix, besides the blocks V and P. The
 * last eliminated row contributes T, R + Q + Q^T, kb and r; the row before the last contributes kb and r. */
typedef struct given {
    int_fast32_t t[9];
    crn_sym3 rest;
    int_fast32_t second, second_before;
    int_fast32_t r[3], r_before[3];
} given;

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

/* Assembles the block R of row i from joints, inertia, wall and balloon. */
static inline crn_sym3 load_rest(const crn_model *model, const crn_state *state, uint32_t i,
                                 const joints3 *joint)
{
    const crn_work *work = &state->scratch.nodes[i];
    const int32_t diagonal = diagonal_of(model, state, i, joint);
    crn_sym3 rest = {{diagonal, 0, 0, diagonal, 0, diagonal}};
    if ((work->wall_normal | work->wall_friction) != 0) {
        add_wall(work, &state->words.nodes[i].tangent_q30, &rest);
        if (work->touching > 1) {
            const crn_second_contact *second = &state->scratch.second[work->touching - 2];
            add_along(&second->normal_q30, second->stiffness, &rest);
        }
    }
    return rest;
}

/* Returns one entry of the matrix T^T V + kb P, which the elimination subtracts from a diagonal block.
 * Overflow is impossible, because the sum is at most 3 * 2^29 * 2^31 + 2^27 * 2^31 < 2^62. */
static inline int32_t taken(const int_fast32_t *t, const int32_t *v_q29, int_fast32_t second, int32_t p_q29)
{
    int64_t sum = (int64_t)t[0] * v_q29[0] + (int64_t)t[3] * v_q29[3] + (int64_t)t[6] * v_q29[6] +
                  (int64_t)second * p_q29 + (1 << 28);
    return crn_narrow64(sum, 29);
}

/* R += R' + Q' + Q'^T - T'^T V' - kb'' P'' */
static inline void gather_rest(crn_sym3 *rest, const given *from, const int32_t *v_q29, const int32_t *p_q29)
{
    const int_fast32_t *t = from->t;
    const int32_t *r = from->rest.m;
    int_fast32_t second = from->second_before;
    rest->m[XX] += r[XX] - taken(t, v_q29, second, p_q29[XX]);
    rest->m[XY] += r[XY] - taken(t, v_q29 + 1, second, p_q29[XY]);
    rest->m[XZ] += r[XZ] - taken(t, v_q29 + 2, second, p_q29[XZ]);
    rest->m[YY] += r[YY] - taken(t + 1, v_q29 + 1, second, p_q29[YY]);
    rest->m[YZ] += r[YZ] - taken(t + 1, v_q29 + 2, second, p_q29[YZ]);
    rest->m[ZZ] += r[ZZ] - taken(t + 2, v_q29 + 2, second, p_q29[ZZ]);
}

/* Computes the block Q = next I + kb' (I - V'^T) of a row; V' and kb' belong to the last eliminated row.
 * Overflow is impossible: kb is below 2^27, because a diagonal entry holds W (a + c)^2 >= 4 kb, so 8 kb
 * fits. */
static inline void gather_upper(int32_t *q, int32_t next, int32_t second, const int32_t *v_q29)
{
    const int32_t minus_q3 = -8 * second;
    const int32_t diagonal = next + second;
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++) {
            q[3 * r + c] = crn_mulh_add(r == c ? diagonal : 0, minus_q3, v_q29[3 * c + r]);
        }
    }
}

/* Returns one component of the right side r + r' - V'^T r' - P'' r'', limited to 256 newtons; one prime marks
 * the last eliminated row, and two primes the row before it. Overflow is impossible: forces are within 2^30,
 * and the magnitudes of a row of V^T and of a row of P add up to less than 2^31 and 2^30, so sums stay below
 * 2^62. */
static inline int32_t gather_force(int64_t sum_N_q22, const int32_t *v_q29, const int_fast32_t *r, int32_t p0,
                                   int32_t p1, int32_t p2, const int_fast32_t *r_before)
{
    int64_t sum = (int64_t)v_q29[0] * r[0] + (int64_t)v_q29[3] * r[1] + (int64_t)v_q29[6] * r[2] +
                  (int64_t)p0 * r_before[0] + (int64_t)p1 * r_before[1] + (int64_t)p2 * r_before[2] +
                  (1 << 28);
    return limit(sum_N_q22 - (sum >> 29), FORCE_MAX_N_Q22);
}

/* Keeps the values of an eliminated row that the next two rows need. */
static inline void give(given *from, const int32_t *q, const int32_t *t, const int32_t *r, int32_t second)
{
    from->rest = (crn_sym3){{t[0] + q[0], t[1] + q[3], t[2] + q[6], t[4] + q[4], t[5] + q[7], t[8] + q[8]}};
    for (int k = 0; k < 9; k++) {
        from->t[k] = t[k];
    }
    for (int k = 0; k < 3; k++) {
        from->r_before[k] = from->r[k];
        from->r[k] = r[k];
    }
    from->second_before = from->second;
    from->second = second;
}

/* Eliminates row i of the matrix. V' belongs to the last eliminated row, and P'' belongs to the row before
 * the last. The assembled forces stay unchanged, so that a second solve can start from these forces. Returns
 * true if a force had to be limited. */
static inline bool eliminate_row(const crn_model *model, crn_state *state, uint32_t i, const joints3 *joint,
                                 const int32_t *v_q29, const int32_t *p_q29, given *from)
{
    crn_work *work = &state->scratch.nodes[i];
    const int32_t *f = work->force_N_q22.v;
    const int32_t *p = p_q29;
    const int_fast32_t *before = from->r;
    const int32_t next = -(joint->here->q + joint->here->r + joint->after->p + joint->after->q);
    const int32_t second = joint->after->q;
    crn_sym3 rest = load_rest(model, state, i, joint);
    gather_rest(&rest, from, v_q29, p_q29);
    int32_t q[9];
    gather_upper(q, next, from->second, v_q29);
    const int32_t r[3] = {
        gather_force((int64_t)f[0] + before[0], v_q29, before, p[XX], p[XY], p[XZ], from->r_before),
        gather_force((int64_t)f[1] + before[1], v_q29 + 1, before, p[XY], p[YY], p[YZ], from->r_before),
        gather_force((int64_t)f[2] + before[2], v_q29 + 2, before, p[XZ], p[YZ], p[ZZ], from->r_before)};
    const int32_t *m = rest.m;
    const int32_t t[9] = {m[XX] + q[0], m[XY] + q[1], m[XZ] + q[2], m[XY] + q[3], m[YY] + q[4],
                          m[YZ] + q[5], m[XZ] + q[6], m[YZ] + q[7], m[ZZ] + q[8]};
    give(from, q, t, r, second);
    add_edge(state, i, &rest);
    inverse3 inverse;
    invert(&rest, &inverse);
    times(&inverse, from->t, work->u.f.w_q29);
    second_neighbour(&inverse, second, &work->u.f.p_q29);
    apply(&inverse, from->r, model->stiffness_exponent, &work->solution_m_q33);
    int32_t largest = 0;
    for (int k = 0; k < 3; k++) {
        largest |= (r[k] < 0 ? -r[k] : r[k]);
    }
    return largest >= FORCE_MAX_N_Q22;
}

/* Eliminates all rows of the matrix in one pass from tip to base. */
static void eliminate(const crn_model *model, crn_state *state)
{
    static const crn_factor none = {{0}, {{0}}};
    static const crn_joint no_joint = {0};
    const crn_factor *ahead = &none, *ahead2 = &none;
    given from = {{0}, {{0}}, 0, 0, {0}, {0}};
    joints3 joint = {NULL, &no_joint, crn_rod_joint(state, 0)};
    bool limited = false;
    for (uint32_t i = 0; i < state->words.free_count; i++) {
        joint = (joints3){joint.here, joint.after, crn_rod_joint(state, i + 1)};
        limited |= eliminate_row(model, state, i, &joint, ahead->w_q29, ahead2->p_q29.m, &from);
        ahead2 = ahead;
        ahead = &state->scratch.nodes[i].u.f;
    }
    if (limited) {
        state->words.fault_bits |= CRN_FAULT_SATURATED;
    }
}

/* Back substitution. Format: Q29 x Q33 -> Q33. Overflow is impossible: displacements are limited to 62 mm, so
 * the sums stay below 2^62. */
static void substitute(crn_state *state)
{
    uint32_t na = state->words.free_count;
    crn_work *work = state->scratch.nodes;
    work[na].solution_m_q33 = (crn_vec3){{0, 0, 0}};
    work[na + 1].solution_m_q33 = (crn_vec3){{0, 0, 0}};
    for (uint32_t n = na; n > 0; n--) {
        crn_work *here = &work[n - 1];
        const int32_t *w = here->u.f.w_q29;
        const int32_t *p = here->u.f.p_q29.m;
        const int32_t *b = here[1].solution_m_q33.v;
        const int32_t *c = here[2].solution_m_q33.v;
        const int32_t pr[9] = {p[XX], p[XY], p[XZ], p[XY], p[YY], p[YZ], p[XZ], p[YZ], p[ZZ]};
        for (int k = 0; k < 3; k++) {
            int64_t sum =
                (int64_t)w[3 * k] * b[0] + (int64_t)w[3 * k + 1] * b[1] + (int64_t)w[3 * k + 2] * b[2];
            sum += (int64_t)pr[3 * k] * c[0] + (int64_t)pr[3 * k + 1] * c[1] + (int64_t)pr[3 * k + 2] * c[2];
            int64_t value = (int64_t)here->solution_m_q33.v[k] + b[k] - crn_rshift_round64(sum, 29);
            here->solution_m_q33.v[k] = limit(value, SOLUTION_MAX_M_Q33);
        }
    }
}

void crn_rod_solve(const crn_model *model, crn_state *state)
{
#if CRN_HAS_LANES
    if (model->has_lanes) {
        if (crn_rod_eliminate_lanes(model, state)) {
            state->words.fault_bits |= CRN_FAULT_SATURATED;
        }
        substitute(state);
        return;
    }
#endif
    eliminate(model, state);
    substitute(state);
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
