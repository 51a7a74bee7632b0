/* This header has the parts of the solve (rod_solve.c) that do not depend on how the processor computes with
 * blocks: the assembly of a row of the matrix, and the inverse of a block. */
#ifndef CRN_CORE_ROD_BLOCK_H
#define CRN_CORE_ROD_BLOCK_H

#include "firmware/core/rod.h"

/* Inverse of a block: D^-1 = mantissa 2^-exponent in units of 1/D. */
typedef struct inverse3 {
    int_fast32_t m[6]; /* |m| <= 2^30 */
    unsigned exponent;
} inverse3;

enum { XX, XY, XZ, YY, YZ, ZZ };
enum {
    FORCE_MAX_N_Q22 = 1 << 30,    /* 256 N; bounds the sums of products below 2^63 */
    SOLUTION_MAX_M_Q33 = 1 << 29, /* 62 mm in one tick; the step cap of core_step.c acts far below that */
};

static inline int32_t limit(int64_t value, int32_t most)
{
    if ((uint64_t)(value + most) <= (uint64_t)most * 2) { /* one comparison for the usual case */
        return (int32_t)value;
    }
    return value > 0 ? most : -most;
}

/* Returns the number of leading zero bits of a non-zero 64-bit value. */
static inline unsigned clz64(uint64_t a)
{
    return (unsigned)__builtin_clzll(a);
}

static inline int64_t minor(int32_t a, int32_t b, int32_t c, int32_t d)
{
    return (int64_t)a * b - (int64_t)c * d;
}

/* Adjugate over determinant. Format: D Q(a), |D| < 2^29, positive definite. The adjugate matrix is computed
 * exactly in 64 bits (2 x 2^58). The adjugate matrix is shifted to 30 bits according to its largest diagonal
 * entry, which bounds every entry of a positive definite matrix. The determinant keeps 22 bits or more while
 * the ratio k_s / w of an edge's axial stiffness to its bending stiffness is at most 2^9. Overflow is
 * impossible, because the determinant of a 3x3 block is below 3 * 2^29 * 2^30. */
static inline void invert(const crn_sym3 *d, inverse3 *inverse)
{
    const int32_t xx = d->m[XX], xy = d->m[XY], xz = d->m[XZ], yy = d->m[YY], yz = d->m[YZ], zz = d->m[ZZ];
    const int64_t n[6] = {minor(yy, zz, yz, yz), minor(xz, yz, xy, zz), minor(xy, yz, xz, yy),
                          minor(xx, zz, xz, xz), minor(xy, xz, xx, yz), minor(xx, yy, xy, xy)};
    uint64_t size = ((uint64_t)(n[XX] | n[YY] | n[ZZ]) & (uint64_t)INT64_MAX) | ((uint64_t)1 << 30);
    unsigned cut = 34 - clz64(size); /* brings the largest diagonal below 2^30: 1 .. 30 */
    int32_t m[6];
    for (int k = 0; k < 6; k++) {
        m[k] = crn_narrow64(n[k], cut);
    }
    int64_t determinant = (int64_t)xx * m[XX] + (int64_t)xy * m[XY] + (int64_t)xz * m[XZ];
    /* For an instrument far softer than the step of the number format, the determinant could fall below 2^31;
     * the lower limit of 2^31 keeps every shift in range. */
    const int64_t least = (int64_t)1 << 31;
    determinant = determinant < least ? least : determinant;
    unsigned lead = clz64((uint64_t)determinant); /* 3 .. 32 */
    /* determinant = mantissa 2^(33 - lead); reciprocal = 2^61 / mantissa */
    int32_t reciprocal = crn_reciprocal_q30((uint32_t)(((uint64_t)determinant << lead) >> 33));
    for (int k = 0; k < 6; k++) {
        inverse->m[k] = crn_mulh(m[k], reciprocal);
    }
    inverse->exponent = 62 - lead; /* 30 .. 59 */
}

/* Returns one component of D^-1 r, limited to 62 mm, from its sum of products. Format: n r -> Q33 m by
 * `shift`. Error: 1/2 LSB. */
static inline int32_t deviation_of(int64_t sum, unsigned shift)
{
    if (shift > 32) { /* the low word cannot carry over */
        int32_t value = crn_asr32(crn_high64(sum) + ((int32_t)1 << (shift - 33)), shift - 32);
        return value > SOLUTION_MAX_M_Q33 ? SOLUTION_MAX_M_Q33
                                          : (value < -SOLUTION_MAX_M_Q33 ? -SOLUTION_MAX_M_Q33 : value);
    }
    int32_t most = (int32_t)1 << (shift < 3 ? 0 : shift - 3); /* upper word of the limit */
    int32_t high = crn_high64(sum);
    if (shift < 32 && shift > 3 && high < most && high >= -most) {
        return crn_narrow64(sum + ((int64_t)1 << (shift - 1)), shift);
    }
    return limit(crn_rshift_round64(sum, shift), SOLUTION_MAX_M_Q33);
}

/* Adds the stiffness k along the vector v, that is, the matrix k v v^T, to a block; the caller passes 4 k,
 * which keeps the fraction that k v in Q(a) would lose. Overflow: |k| < 2^29. */
static inline void add_along4(const crn_vec3 *v_q30, int32_t stiffness4, crn_sym3 *d)
{
    int32_t x = 4 * crn_mulh(stiffness4, v_q30->v[0]);
    int32_t y = 4 * crn_mulh(stiffness4, v_q30->v[1]);
    int32_t z = 4 * crn_mulh(stiffness4, v_q30->v[2]);
    d->m[XX] = crn_mulh_add(d->m[XX], x, v_q30->v[0]);
    d->m[XY] = crn_mulh_add(d->m[XY], x, v_q30->v[1]);
    d->m[XZ] = crn_mulh_add(d->m[XZ], x, v_q30->v[2]);
    d->m[YY] = crn_mulh_add(d->m[YY], y, v_q30->v[1]);
    d->m[YZ] = crn_mulh_add(d->m[YZ], y, v_q30->v[2]);
    d->m[ZZ] = crn_mulh_add(d->m[ZZ], z, v_q30->v[2]);
}
static inline void add_along(const crn_vec3 *v_q30, int32_t stiffness, crn_sym3 *d)
{
    add_along4(v_q30, 4 * stiffness, d);
}

/* Adds the stiffness S of the edge behind node i, in Q(a). Format: (4 k) t keeps the fraction that k t in
 * Q(a) would lose. Overflow is impossible, because the entries of S are at most k_s, which is below 2^29. */
static inline void add_edge(const crn_state *state, uint32_t i, crn_sym3 *d)
{
    const crn_vec3 *t = &state->words.nodes[i].tangent_q30;
    int32_t geometric = state->scratch.nodes[i].geometric;
    d->m[XX] += geometric;
    d->m[YY] += geometric;
    d->m[ZZ] += geometric;
    add_along(t, state->line.nodes[i].spring - geometric, d);
}

/* Holds pointers to the joints i-1, i and i+1, which contribute to row i of the matrix. */
typedef struct joints3 {
    const crn_joint *before, *here, *after;
} joints3;

/* Returns the entry of the block R of row i that is the same on the whole diagonal: joints, inertia and
 * balloon. */
static inline int32_t diagonal_of(const crn_model *model, const crn_state *state, uint32_t i,
                                  const joints3 *joint)
{
    const crn_joint *here = joint->here;
    return crn_line_inertia(model, &state->line.nodes[i]) + joint->before->r + here->p + 2 * here->q +
           here->r + joint->after->p + state->scratch.nodes[i].tied;
}

/* --- a row -----------------------------------------------------------------------------------------------
 *
 * The elimination of a row takes a quarter of a tick. On a Cortex-M7 it is written in assembly
 * (core_m7.c), because a compiler spends a quarter of it on moving numbers between registers and the
 * stack. Every other processor runs the same steps in C (rod_solve.c). Both compute the same bits, which
 * tools/check/core_hash.c checks on random rows. */
#define CRN_ROW_BY_ASSEMBLY CRN_HIGH_WORDS_BY_DSP

/* One prime marks values of the last eliminated row, and two primes those of the row before it. The blocks
 * are those of rod_solve.c. Blocks of nine numbers are stored by columns, symmetric ones as crn_sym3. */
typedef struct crn_row {
    uint32_t saved[9];           /* registers of the caller, for the assembly */
    crn_factor *factor;          /* out: V by rows, P */
    const crn_factor *last;      /* V' by rows */
    const crn_sym3 *p_before;    /* P'' */
    const crn_vec3 *tangent_q30; /* of the edge behind the node */
    int32_t spring4;             /* 4 (k_s - k_g) of that edge */
    int32_t geometric;           /* its k_g */
    int32_t minus_second8;       /* -8 kb' */
    int32_t diagonal;            /* of the joints' part of Q, plus kb' */
    int32_t second;              /* kb of this row */
    int32_t second_before;       /* kb'' */
    crn_sym3 rest; /* in: R' + Q' + Q'^T + this row's R without the wall; out: R + Q + Q^T for the next row */
    int32_t t[9];  /* in: T'; out: T */
    int32_t v_q29[9]; /* in: V'; out: V */
    int32_t inverse[6];
    uint32_t exponent;           /* out: D^-1 = inverse 2^-exponent */
    const crn_vec3 *force_N_q22; /* of this node */
    crn_vec3 *solution_m_q33;    /* out: D^-1 r */
    int32_t r[3];                /* in: r'; out: r */
    int32_t r_before[3];         /* in: r''; out: r' */
    uint32_t force_exponent;     /* of D, plus 11: the shift of D^-1 r is `exponent` less this */
    const crn_work *wall;        /* of a touching node; NULL: nothing touches it */
} crn_row;

/* Computes T, V, P, D^-1 of a row, and what the next row receives of its R and Q. Overflow is impossible: see
 * rod_solve.c. */
void crn_row_factor(crn_row *row);

/* Computes the right side r of a row whose blocks crn_row_factor() has computed, and D^-1 r. Returns true if
 * a force reached its limit of 256 N. */
bool crn_row_any_force(crn_row *row);

#if CRN_ROW_BY_ASSEMBLY
/* As crn_row_any_force() for the usual case, in which no force is above 128 N, D^-1 r is below 62 mm, and its
 * shift is 1 .. 31 or 33 .. 63. Returns false, and changes nothing, in every other case. */
bool crn_row_usual_force(crn_row *row);

/* Substitutes back from the node `last`, which is the node number `count` from the tip, to the tip. Returns
 * 0; or, at a component whose sum is too large for the assembly, 4 times the node's number plus the
 * component. `saved` is memory for nine registers of the caller. */
uint32_t crn_row_substitute(crn_work *last, uint32_t count, uint32_t *saved);
#endif

static inline bool crn_row_force(crn_row *row)
{
#if CRN_ROW_BY_ASSEMBLY
    if (crn_row_usual_force(row)) {
        return false;
    }
#endif
    return crn_row_any_force(row);
}

/* Substitutes back for all free nodes, from the base to the tip. */
void crn_rod_substitute(crn_state *state);

#endif
