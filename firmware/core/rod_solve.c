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
    seld_sym3 mantissa; /* |m| <= 2^29 */
    unsigned exponent;
} inverse3;

enum { XX, XY, XZ, YY, YZ, ZZ };
enum {
    FORCE_MAX_N_Q22 = 1 << 30,    /* 256 N; bounds the sums of products below 2^63 */
    SOLUTION_MAX_M_Q33 = 1 << 29, /* 62 mm in one tick; the step cap of core_step.c acts far below */
};

static int32_t limit(int64_t value, int32_t most)
{
    return value > most ? most : (value < -most ? -most : (int32_t)value);
}

static int64_t abs64(int64_t a)
{
    return a < 0 ? -a : a;
}

static unsigned clz64(uint64_t a)
{
    return a == 0 ? 64u : (unsigned)__builtin_clzll(a);
}

/* Adjugate over determinant. Format: D Q(a), |D| < 2^29, positive definite.
 * The adjugate is exact in 64 bits (2 x 2^58), cut to 29 bits by its largest diagonal, which bounds every
 * entry of a positive definite matrix. The determinant keeps 22 bits or more while k_s / w <= 2^9. Overflow:
 * determinant below 3 * 2^29 * 2^29. */
static inverse3 invert(const seld_sym3 *d)
{
    const int32_t *m = d->m;
    int64_t adj[6];
    adj[XX] = (int64_t)m[YY] * m[ZZ] - (int64_t)m[YZ] * m[YZ];
    adj[XY] = (int64_t)m[XZ] * m[YZ] - (int64_t)m[XY] * m[ZZ];
    adj[XZ] = (int64_t)m[XY] * m[YZ] - (int64_t)m[XZ] * m[YY];
    adj[YY] = (int64_t)m[XX] * m[ZZ] - (int64_t)m[XZ] * m[XZ];
    adj[YZ] = (int64_t)m[XY] * m[XZ] - (int64_t)m[XX] * m[YZ];
    adj[ZZ] = (int64_t)m[XX] * m[YY] - (int64_t)m[XY] * m[XY];
    uint64_t size =
        (uint64_t)abs64(adj[XX]) | (uint64_t)abs64(adj[YY]) | (uint64_t)abs64(adj[ZZ]) | ((uint64_t)1 << 29);
    unsigned cut = 35 - clz64(size); /* largest diagonal to below 2^29 */
    inverse3 inverse;
    for (int k = 0; k < 6; k++) {
        inverse.mantissa.m[k] = (int32_t)seld_rshift_round64(adj[k], cut);
    }
    int32_t *n = inverse.mantissa.m;
    int64_t determinant = (int64_t)m[XX] * n[XX] + (int64_t)m[XY] * n[XY] + (int64_t)m[XZ] * n[XZ];
    determinant = determinant < 1 ? 1 : determinant;
    unsigned lead = clz64((uint64_t)determinant);
    uint32_t mantissa = (uint32_t)(((uint64_t)determinant << lead) >> 33);
    int64_t reciprocal =
        seld_reciprocal_q30(mantissa); /* 2^61 / mantissa, determinant = mantissa 2^(33 - lead) */
    for (int k = 0; k < 6; k++) {
        n[k] = (int32_t)seld_rshift_round64(n[k] * reciprocal, 31);
    }
    inverse.exponent = 63 - lead;
    return inverse;
}

/* D^-1 U in Q29, column by column. Overflow: 3 * 2^29 * 2^29 in the sum; |W| <= 2 for meshes that grow to the
 * base. */
static void times(const inverse3 *inverse, const mat3 *u, int32_t *w_q29)
{
    const int32_t *n = inverse->mantissa.m;
    unsigned shift = inverse->exponent - 29;
    for (int c = 0; c < 3; c++) {
        int64_t x = u->m[c];
        int64_t y = u->m[3 + c];
        int64_t z = u->m[6 + c];
        w_q29[c] = (int32_t)seld_rshift_round64(n[XX] * x + n[XY] * y + n[XZ] * z, shift);
        w_q29[3 + c] = (int32_t)seld_rshift_round64(n[XY] * x + n[YY] * y + n[YZ] * z, shift);
        w_q29[6 + c] = (int32_t)seld_rshift_round64(n[XZ] * x + n[YZ] * y + n[ZZ] * z, shift);
    }
}

/* delta = D^-1 r. Format: r Q22 N -> Q33 m: shift = exponent - a - 11. Overflow: limited to 62 mm. */
static seld_vec3 apply(const inverse3 *inverse, const seld_vec3 *r, unsigned exponent_a)
{
    const int32_t *n = inverse->mantissa.m;
    unsigned shift = inverse->exponent - exponent_a - 11;
    int64_t x = r->v[0];
    int64_t y = r->v[1];
    int64_t z = r->v[2];
    const int64_t sum[3] = {n[XX] * x + n[XY] * y + n[XZ] * z, n[XY] * x + n[YY] * y + n[YZ] * z,
                            n[XZ] * x + n[YZ] * y + n[ZZ] * z};
    return seld_vec3_make(limit(seld_rshift_round64(sum[0], shift), SOLUTION_MAX_M_Q33),
                          limit(seld_rshift_round64(sum[1], shift), SOLUTION_MAX_M_Q33),
                          limit(seld_rshift_round64(sum[2], shift), SOLUTION_MAX_M_Q33));
}

/* Row i of the assembled matrix before elimination. */
static void load_diagonal(const seld_state *state, uint32_t i, seld_sym3 *d)
{
    const seld_work *work = &state->scratch.nodes[i];
    for (int k = 0; k < 6; k++) {
        d->m[k] = work->spring.m[k] + work->wall.m[k] + (i > 0 ? work[-1].spring.m[k] : 0);
    }
    d->m[XX] += work->diagonal;
    d->m[YY] += work->diagonal;
    d->m[ZZ] += work->diagonal;
}

static void load_upper(const seld_work *work, mat3 *u)
{
    const int32_t *s = work->spring.m;
    int32_t off = work->off_diagonal;
    *u = (mat3){{off - s[XX], -s[XY], -s[XZ], -s[XY], off - s[YY], -s[YZ], -s[XZ], -s[YZ], off - s[ZZ]}};
}

/* D -= U^T W. Overflow: 3 * 2^29 * 2^31 < 2^62. */
static void subtract_product(seld_sym3 *d, const mat3 *u, const int32_t *w_q29)
{
    static const uint8_t row[6] = {0, 0, 0, 1, 1, 2};
    static const uint8_t column[6] = {0, 1, 2, 1, 2, 2};
    for (int k = 0; k < 6; k++) {
        int64_t sum = (int64_t)u->m[row[k]] * w_q29[column[k]] +
                      (int64_t)u->m[3 + row[k]] * w_q29[3 + column[k]] +
                      (int64_t)u->m[6 + row[k]] * w_q29[6 + column[k]];
        d->m[k] -= (int32_t)seld_rshift_round64(sum, 29);
    }
}

/* U[i+1] -= kb W^T */
static void subtract_second(mat3 *u, int32_t second, const int32_t *w_q29)
{
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++) {
            u->m[3 * r + c] -= (int32_t)seld_rshift_round64((int64_t)second * w_q29[3 * c + r], 29);
        }
    }
}

/* r' -= M^T r for a general block. Overflow: force saturates at 2^30 (256 N), so sums stay below 3 * 2^30 *
 * 2^31. */
static void subtract_transposed(seld_vec3 *target, const int32_t *w_q29, const seld_vec3 *r)
{
    for (int k = 0; k < 3; k++) {
        int64_t sum =
            (int64_t)w_q29[k] * r->v[0] + (int64_t)w_q29[3 + k] * r->v[1] + (int64_t)w_q29[6 + k] * r->v[2];
        target->v[k] = limit(target->v[k] - seld_rshift_round64(sum, 29), FORCE_MAX_N_Q22);
    }
}

static void subtract_symmetric(seld_vec3 *target, const seld_sym3 *p_q29, const seld_vec3 *r)
{
    const int32_t *p = p_q29->m;
    const int32_t full[9] = {p[XX], p[XY], p[XZ], p[XY], p[YY], p[YZ], p[XZ], p[YZ], p[ZZ]};
    subtract_transposed(target, full, r);
}

/* One pass from tip to base. The right side is copied so that a second solve can start from the assembled
 * forces. */
static void eliminate(const seld_model *model, seld_state *state)
{
    uint32_t na = state->words.free_count;
    seld_work *work = state->scratch.nodes;
    seld_sym3 d, d_next, d_after;
    mat3 u, u_next;
    seld_vec3 r = work[0].force_N_q22;
    seld_vec3 r_next = work[1].force_N_q22;
    load_diagonal(state, 0, &d);
    load_upper(&work[0], &u);
    load_diagonal(state, 1, &d_next);
    for (uint32_t i = 0; i < na; i++) {
        load_diagonal(state, i + 2, &d_after);
        load_upper(&work[i + 1], &u_next);
        seld_vec3 r_after = work[i + 2].force_N_q22;
        inverse3 inverse = invert(&d);
        times(&inverse, &u, work[i].w_q29);
        int32_t second = work[i].off_second;
        for (int k = 0; k < 6; k++) {
            work[i].p_q29.m[k] =
                (int32_t)seld_rshift_round64((int64_t)inverse.mantissa.m[k] * second, inverse.exponent - 29);
            d_after.m[k] -= (int32_t)seld_rshift_round64((int64_t)work[i].p_q29.m[k] * second, 29);
        }
        work[i].solution_m_q33 = apply(&inverse, &r, model->stiffness_exponent);
        subtract_transposed(&r_next, work[i].w_q29, &r);
        subtract_symmetric(&r_after, &work[i].p_q29, &r);
        subtract_product(&d_next, &u, work[i].w_q29);
        subtract_second(&u_next, second, work[i].w_q29);
        d = d_next;
        d_next = d_after;
        u = u_next;
        r = r_next;
        r_next = r_after;
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
        const int32_t *w = here->w_q29;
        const int32_t *p = here->p_q29.m;
        const int32_t *b = here[1].solution_m_q33.v;
        const int32_t *c = here[2].solution_m_q33.v;
        const int32_t pr[9] = {p[XX], p[XY], p[XZ], p[XY], p[YY], p[YZ], p[XZ], p[YZ], p[ZZ]};
        for (int k = 0; k < 3; k++) {
            int64_t sum =
                (int64_t)w[3 * k] * b[0] + (int64_t)w[3 * k + 1] * b[1] + (int64_t)w[3 * k + 2] * b[2];
            sum += (int64_t)pr[3 * k] * c[0] + (int64_t)pr[3 * k + 1] * c[1] + (int64_t)pr[3 * k + 2] * c[2];
            int64_t value = here->solution_m_q33.v[k] - seld_rshift_round64(sum, 29);
            here->solution_m_q33.v[k] = limit(value, SOLUTION_MAX_M_Q33);
        }
    }
}

void seld_rod_solve(const seld_model *model, seld_state *state)
{
    eliminate(model, state);
    substitute(state);
}
