/* The implicit step: A delta = r by block LDL^T, 3x3 blocks, two blocks to the right, from tip to base.
 *
 *   A[i][i] = D,  A[i][i+1] = U,  A[i][i+2] = kb I;  nodes na, na+1 do not deviate from the slide (delta = 0)
 *   W = D^-1 U, P = kb D^-1
 *   r[i+1] -= W^T r[i]     r[i+2] -= P r[i]
 *   D[i+1] -= U^T W        U[i+1] -= kb W^T        D[i+2] -= kb P
 *   back: delta[i] = D^-1 r[i] - W delta[i+1] - P delta[i+2]
 *
 * From the tip the free rod's bending factor is exactly [1, -2, 1], so nothing cancels. One reciprocal per
 * node, by Newton; no divide. Formats: D, U, kb in Q(a) N/m below 2^29; W, P in Q29; r in Q22 N; delta in Q33
 * m. May include: rod.h. Called by: core_step.c. */
#include "firmware/core/rod.h"

typedef struct mat3 {
    int32_t m[9];
} mat3;

/* Inverse of a block: D^-1 = mantissa 2^-exponent in units of 1/D. */
typedef struct inverse3 {
    int64_t m[6]; /* |m| <= 2^29 */
    unsigned exponent;
} inverse3;

enum { XX, XY, XZ, YY, YZ, ZZ };
enum {
    FORCE_MAX_N_Q22 = 1 << 30,    /* 256 N; bounds the sums of products below 2^63 */
    SOLUTION_MAX_M_Q33 = 1 << 29, /* 62 mm in one tick; the step cap of core_step.c acts far below */
};

static inline int32_t limit(int64_t value, int32_t most)
{
    if ((uint64_t)(value + most) <= (uint64_t)most * 2) { /* one comparison for the usual case */
        return (int32_t)value;
    }
    return value > 0 ? most : -most;
}

/* Leading zeros of a non-zero value. */
static inline unsigned clz64(uint64_t a)
{
    return (unsigned)__builtin_clzll(a);
}

/* Adjugate over determinant. Format: D Q(a), |D| < 2^29, positive definite.
 * The adjugate is exact in 64 bits (2 x 2^58), cut to 29 bits by its largest diagonal, which bounds every entry of a
 * positive definite matrix. The determinant keeps 22 bits or more while k_s / w <= 2^9.
 * Overflow: determinant below 3 * 2^29 * 2^29. */
static inline void invert(const seld_sym3 *d, inverse3 *inverse)
{
    const int64_t xx = d->m[XX], xy = d->m[XY], xz = d->m[XZ], yy = d->m[YY], yz = d->m[YZ], zz = d->m[ZZ];
    int64_t *n = inverse->m;
    n[XX] = yy * zz - yz * yz;
    n[XY] = xz * yz - xy * zz;
    n[XZ] = xy * yz - xz * yy;
    n[YY] = xx * zz - xz * xz;
    n[YZ] = xy * xz - xx * yz;
    n[ZZ] = xx * yy - xy * xy;
    uint64_t size = ((uint64_t)(n[XX] | n[YY] | n[ZZ]) & (uint64_t)INT64_MAX) | ((uint64_t)1 << 29);
    unsigned cut = 35 - clz64(size); /* largest diagonal to below 2^29 */
    int64_t half = (int64_t)1 << (cut - 1);
    for (int k = 0; k < 6; k++) {
        n[k] = (n[k] + half) >> cut;
    }
    int64_t determinant = xx * n[XX] + xy * n[XY] + xz * n[XZ];
    /* An instrument far softer than its format's step could fall below; the floor keeps every shift in range. */
    const int64_t least = (int64_t)1 << 30;
    determinant = determinant < least ? least : determinant;
    unsigned lead = clz64((uint64_t)determinant);
    /* determinant = mantissa 2^(33 - lead); reciprocal = 2^61 / mantissa */
    int64_t reciprocal = seld_reciprocal_q30((uint32_t)(((uint64_t)determinant << lead) >> 33));
    for (int k = 0; k < 6; k++) {
        n[k] = (n[k] * reciprocal + ((int64_t)1 << 30)) >> 31;
    }
    inverse->exponent = 63 - lead;
}

/* D^-1 U in Q29, column by column. Overflow: 3 * 2^29 * 2^29 in the sum; |W| <= 2 for meshes that grow to the base. */
static inline void times(const inverse3 *inverse, const mat3 *u, int32_t *w_q29)
{
    const int64_t *n = inverse->m;
    unsigned shift = inverse->exponent - 29;
    int64_t half = (int64_t)1 << (shift - 1);
    for (int c = 0; c < 3; c++) {
        int64_t x = u->m[c];
        int64_t y = u->m[3 + c];
        int64_t z = u->m[6 + c];
        w_q29[c] = (int32_t)((n[XX] * x + n[XY] * y + n[XZ] * z + half) >> shift);
        w_q29[3 + c] = (int32_t)((n[XY] * x + n[YY] * y + n[YZ] * z + half) >> shift);
        w_q29[6 + c] = (int32_t)((n[XZ] * x + n[YZ] * y + n[ZZ] * z + half) >> shift);
    }
}

/* delta = D^-1 r. Format: r Q22 N -> Q33 m: shift = exponent - a - 11. Overflow: limited to 62 mm. */
static inline void apply(const inverse3 *inverse, const int32_t *r, unsigned exponent_a, seld_vec3 *delta)
{
    const int64_t *n = inverse->m;
    unsigned shift = inverse->exponent - exponent_a - 11;
    int64_t half = (int64_t)1 << (shift - 1);
    delta->v[0] = limit((n[XX] * r[0] + n[XY] * r[1] + n[XZ] * r[2] + half) >> shift, SOLUTION_MAX_M_Q33);
    delta->v[1] = limit((n[XY] * r[0] + n[YY] * r[1] + n[YZ] * r[2] + half) >> shift, SOLUTION_MAX_M_Q33);
    delta->v[2] = limit((n[XZ] * r[0] + n[YZ] * r[1] + n[ZZ] * r[2] + half) >> shift, SOLUTION_MAX_M_Q33);
}

/* P = kb D^-1 in Q29 and D[i+2] -= kb P. */
static inline void second_neighbour(const inverse3 *inverse, int64_t second, seld_sym3 *p_q29,
                                    seld_sym3 *d_after)
{
    unsigned shift = inverse->exponent - 29;
    int64_t half = (int64_t)1 << (shift - 1);
    for (int k = 0; k < 6; k++) {
        int64_t p = (inverse->m[k] * second + half) >> shift;
        p_q29->m[k] = (int32_t)p;
        d_after->m[k] -= (int32_t)((p * second + (1 << 28)) >> 29);
    }
}

/* Row i of the bending matrix and inertia: joints i-1, i and i+1 around it (docs/rod.md, "rows"). */
typedef struct bend_row {
    int32_t diagonal, next, second;
} bend_row;

static inline bend_row bend_row_of(const seld_model *model, const seld_state *state, uint32_t i)
{
    static const seld_joint none = {0};
    const seld_joint *before =
        i > 0 ? &state->line.nodes[i - 1].joint : &none; /* never a clipped one: i < na */
    const seld_joint *here = seld_rod_joint(state, i);
    const seld_joint *after = seld_rod_joint(state, i + 1);
    int32_t inertia = seld_line_inertia(model, &state->line.nodes[i]);
    return (bend_row){inertia + before->r + here->p + 2 * here->q + here->r + after->p,
                      -(here->q + here->r + after->p + after->q), after->q};
}

/* S of the edge behind node i in Q(a). Overflow: |S| <= k_s < 2^29. */
static inline void edge_matrix(const seld_state *state, uint32_t i, seld_sym3 *s)
{
    const seld_vec3 *t = &state->words.nodes[i].tangent_q30;
    int32_t geometric = state->scratch.nodes[i].geometric;
    int32_t along = state->line.nodes[i].spring - geometric;
    int32_t x = seld_scale_q30(along, t->v[0]);
    int32_t y = seld_scale_q30(along, t->v[1]);
    int32_t z = seld_scale_q30(along, t->v[2]);
    s->m[XX] = seld_scale_q30(x, t->v[0]) + geometric;
    s->m[XY] = seld_scale_q30(x, t->v[1]);
    s->m[XZ] = seld_scale_q30(x, t->v[2]);
    s->m[YY] = seld_scale_q30(y, t->v[1]) + geometric;
    s->m[YZ] = seld_scale_q30(y, t->v[2]);
    s->m[ZZ] = seld_scale_q30(z, t->v[2]) + geometric;
}

/* k v v^T added to a block. */
static inline void add_along(const seld_vec3 *v_q30, int32_t stiffness, seld_sym3 *d)
{
    int32_t x = seld_scale_q30(stiffness, v_q30->v[0]);
    int32_t y = seld_scale_q30(stiffness, v_q30->v[1]);
    int32_t z = seld_scale_q30(stiffness, v_q30->v[2]);
    d->m[XX] += seld_scale_q30(x, v_q30->v[0]);
    d->m[XY] += seld_scale_q30(x, v_q30->v[1]);
    d->m[XZ] += seld_scale_q30(x, v_q30->v[2]);
    d->m[YY] += seld_scale_q30(y, v_q30->v[1]);
    d->m[YZ] += seld_scale_q30(y, v_q30->v[2]);
    d->m[ZZ] += seld_scale_q30(z, v_q30->v[2]);
}

/* Adds k_n n n^T + k_f (I - n n^T) + k_r (I - n n^T - t' t'^T) of a touching node, t' the tangent across n. A step across
 * both turns the normal force with the round wall, which without k_r = N / r swings for ever where nothing rubs
 * (docs/rod.md, "contact"). A tip that meets the wall head on has no t': k_r acts all round. */
static inline void add_wall(const seld_work *work, const seld_vec3 *tangent, seld_sym3 *d)
{
    const seld_vec3 *n = &work->normal_q30;
    int32_t round = work->touching ? work->wall_round : 0;
    int32_t across = work->wall_friction + round;
    add_along(n, work->wall_normal - across, d);
    if (round != 0) {
        int32_t inwards = seld_vec3_dot_unit(tangent, n);
        seld_vec3 flat;
        for (int k = 0; k < 3; k++) {
            flat.v[k] = tangent->v[k] - seld_scale_q30(inwards, n->v[k]);
        }
        add_along(&flat, -round, d);
    }
    d->m[XX] += across;
    d->m[YY] += across;
    d->m[ZZ] += across;
}

/* One entry of T^T V. Overflow: 3 * 2^29 * 2^31 < 2^62. */
static inline int32_t column_product(const mat3 *t, int a, const int32_t *v_q29, int b)
{
    int64_t sum = (int64_t)t->m[a] * v_q29[b] + (int64_t)t->m[3 + a] * v_q29[3 + b] +
                  (int64_t)t->m[6 + a] * v_q29[6 + b];
    return (int32_t)((sum + (1 << 28)) >> 29);
}

/* R[i+1] += R + Q + Q^T - T^T V */
static inline void pass_remainder(const seld_sym3 *r, const mat3 *q, const mat3 *t, const int32_t *v_q29,
                                  seld_sym3 *next)
{
    next->m[XX] += r->m[XX] + 2 * q->m[0] - column_product(t, 0, v_q29, 0);
    next->m[XY] += r->m[XY] + q->m[1] + q->m[3] - column_product(t, 0, v_q29, 1);
    next->m[XZ] += r->m[XZ] + q->m[2] + q->m[6] - column_product(t, 0, v_q29, 2);
    next->m[YY] += r->m[YY] + 2 * q->m[4] - column_product(t, 1, v_q29, 1);
    next->m[YZ] += r->m[YZ] + q->m[5] + q->m[7] - column_product(t, 1, v_q29, 2);
    next->m[ZZ] += r->m[ZZ] + 2 * q->m[8] - column_product(t, 2, v_q29, 2);
}

/* Q[i+1] += kb (I - V^T) */
static inline void pass_second(mat3 *q, int64_t second, const int32_t *v_q29)
{
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++) {
            q->m[3 * r + c] -= (int32_t)((second * v_q29[3 * c + r] + (1 << 28)) >> 29);
        }
        q->m[4 * r] += (int32_t)second;
    }
}

/* r[i+1] -= W^T r = V^T r - r and r[i+2] -= P r. Overflow: r is limited to 2^30, so sums stay below 3 * 2^30 * 2^31; what
 * is carried stays in 64 bits until its own turn. */
static inline void subtract_forces(int64_t *next, int64_t *after, const seld_work *work, const int32_t *r)
{
    const int32_t *v = work->u.f.w_q29;
    const int32_t *p = work->u.f.p_q29.m;
    const int64_t x = r[0], y = r[1], z = r[2];
    for (int k = 0; k < 3; k++) {
        next[k] += r[k] - ((v[k] * x + v[3 + k] * y + v[6 + k] * z + (1 << 28)) >> 29);
    }
    after[0] -= (p[XX] * x + p[XY] * y + p[XZ] * z + (1 << 28)) >> 29;
    after[1] -= (p[XY] * x + p[YY] * y + p[YZ] * z + (1 << 28)) >> 29;
    after[2] -= (p[XZ] * x + p[YZ] * y + p[ZZ] * z + (1 << 28)) >> 29;
}

/* What one node of the elimination holds; three of them rotate. */
typedef struct row3 {
    seld_sym3 remainder; /* R */
    seld_sym3 spring;    /* S of the edge behind the node */
    mat3 q;
    int32_t second;
    int64_t r[3];
} row3;

/* Assembles row i. */
static inline void load_row(const seld_model *model, const seld_state *state, uint32_t i, row3 *row)
{
    const seld_work *work = &state->scratch.nodes[i];
    bend_row bend = bend_row_of(model, state, i);
    edge_matrix(state, i, &row->spring);
    row->remainder = (seld_sym3){{bend.diagonal, 0, 0, bend.diagonal, 0, bend.diagonal}};
    if ((work->wall_normal | work->wall_friction) != 0) {
        add_wall(work, &state->words.nodes[i].tangent_q30, &row->remainder);
    }
    row->q = (mat3){{bend.next, 0, 0, 0, bend.next, 0, 0, 0, bend.next}};
    row->second = bend.second;
    for (int k = 0; k < 3; k++) {
        row->r[k] = work->force_N_q22.v[k];
    }
}

/* Eliminates node `work`; the forces are copied so that a second solve can start from what was assembled. Returns
 * non-zero bits when a force had to be limited. */
static inline int64_t eliminate_node(unsigned exponent, seld_work *work, const row3 *here, row3 *next,
                                     row3 *after)
{
    const int32_t r[3] = {limit(here->r[0], FORCE_MAX_N_Q22), limit(here->r[1], FORCE_MAX_N_Q22),
                          limit(here->r[2], FORCE_MAX_N_Q22)};
    inverse3 inverse;
    const seld_sym3 *rest = &here->remainder;
    seld_sym3 d;
    for (int k = 0; k < 6; k++) {
        d.m[k] = rest->m[k] + here->spring.m[k];
    }
    mat3 t = here->q;
    const int32_t full[9] = {rest->m[XX], rest->m[XY], rest->m[XZ], rest->m[XY], rest->m[YY],
                             rest->m[YZ], rest->m[XZ], rest->m[YZ], rest->m[ZZ]};
    for (int k = 0; k < 9; k++) {
        t.m[k] += full[k];
    }
    invert(&d, &inverse);
    times(&inverse, &t, work->u.f.w_q29);
    second_neighbour(&inverse, here->second, &work->u.f.p_q29, &after->remainder);
    apply(&inverse, r, exponent, &work->solution_m_q33);
    subtract_forces(next->r, after->r, work, r);
    pass_remainder(rest, &here->q, &t, work->u.f.w_q29, &next->remainder);
    pass_second(&next->q, here->second, work->u.f.w_q29);
    return (here->r[0] ^ r[0]) | (here->r[1] ^ r[1]) | (here->r[2] ^ r[2]);
}

/* One pass from tip to base. Rows of the held nodes stay empty: they do not deviate. */
static void eliminate(const seld_model *model, seld_state *state)
{
    static const row3 held = {{{0}}, {{0}}, {{0}}, 0, {0}};
    uint32_t na = state->words.free_count;
    row3 rows[3];
    row3 *here = &rows[0], *next = &rows[1], *after = &rows[2];
    int64_t limited = 0;
    load_row(model, state, 0, here);
    load_row(model, state, 1, next);
    for (uint32_t i = 0; i < na; i++) {
        if (i + 2 < na) {
            load_row(model, state, i + 2, after);
        } else {
            *after = held;
        }
        limited |= eliminate_node(model->stiffness_exponent, &state->scratch.nodes[i], here, next, after);
        row3 *done = here;
        here = next;
        next = after;
        after = done;
    }
    if (limited != 0) {
        state->words.fault_bits |= SELD_FAULT_SATURATED;
    }
}

/* Back substitution. Format: Q29 x Q33 -> Q33. Overflow: limited to 62 mm, so the sums stay below 2^62. */
static void substitute(seld_state *state)
{
    uint32_t na = state->words.free_count;
    seld_work *work = state->scratch.nodes;
    work[na].solution_m_q33 = (seld_vec3){{0, 0, 0}};
    work[na + 1].solution_m_q33 = (seld_vec3){{0, 0, 0}};
    for (uint32_t n = na; n > 0; n--) {
        seld_work *here = &work[n - 1];
        const int32_t *w = here->u.f.w_q29;
        const int32_t *p = here->u.f.p_q29.m;
        const int32_t *b = here[1].solution_m_q33.v;
        const int32_t *c = here[2].solution_m_q33.v;
        const int32_t pr[9] = {p[XX], p[XY], p[XZ], p[XY], p[YY], p[YZ], p[XZ], p[YZ], p[ZZ]};
        for (int k = 0; k < 3; k++) {
            int64_t sum =
                (int64_t)w[3 * k] * b[0] + (int64_t)w[3 * k + 1] * b[1] + (int64_t)w[3 * k + 2] * b[2];
            sum += (int64_t)pr[3 * k] * c[0] + (int64_t)pr[3 * k + 1] * c[1] + (int64_t)pr[3 * k + 2] * c[2];
            int64_t value = (int64_t)here->solution_m_q33.v[k] + b[k] - seld_rshift_round64(sum, 29);
            here->solution_m_q33.v[k] = limit(value, SOLUTION_MAX_M_Q33);
        }
    }
}

void seld_rod_solve(const seld_model *model, seld_state *state)
{
    eliminate(model, state);
    substitute(state);
}

/* Force of the line on the two held nodes: f - A delta. Bending is part of it: the edge force alone jumps when a node is
 * freed and reads low with a bent mouth (docs/rod.md). */
int32_t seld_rod_handle_axial(const seld_model *model, const seld_state *state)
{
    uint32_t na = state->words.free_count;
    const seld_work *work = state->scratch.nodes;
    seld_sym3 spring;
    edge_matrix(state, na - 1, &spring);
    const int32_t *s = spring.m;
    const seld_joint *last = &state->scratch.mouth[0]; /* joints na-1 and na */
    const seld_joint *held = &state->scratch.mouth[1];
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
        force -= seld_rshift_round64(moved, shift);
        axial -= force * model->entry.direction_q30.v[k];
    }
    return seld_sat32(seld_rshift_round64(axial, 30));
}
