/* Three-component vectors in fixed point. A vector's number format is that of its components, and is the
 * suffix of the variable's name. */
#ifndef CRN_VECTOR_H
#define CRN_VECTOR_H

#include "firmware/core/fixed.h"

typedef struct crn_vec3 {
    int32_t v[3];
} crn_vec3;

static inline crn_vec3 crn_vec3_make(int32_t x, int32_t y, int32_t z)
{
    crn_vec3 r = {{x, y, z}};
    return r;
}

/* Format: same in and out. Overflow: saturates. */
static inline crn_vec3 crn_vec3_add(crn_vec3 a, crn_vec3 b)
{
    return crn_vec3_make(crn_add_sat(a.v[0], b.v[0]), crn_add_sat(a.v[1], b.v[1]),
                         crn_add_sat(a.v[2], b.v[2]));
}
static inline crn_vec3 crn_vec3_sub(crn_vec3 a, crn_vec3 b)
{
    return crn_vec3_make(crn_sub_sat(a.v[0], b.v[0]), crn_sub_sat(a.v[1], b.v[1]),
                         crn_sub_sat(a.v[2], b.v[2]));
}

/* Raw dot product. Format: Qa . Qb -> Q(a+b) in 64 bits. Overflow is impossible in two cases: the components
 * of both vectors stay below 2^31 * 0.81 (3 * 0.81^2 < 2), or the components of one vector stay within +-2^30
 * (3 * 2^61 < 2^63). Error: exact. */
static inline int64_t crn_vec3_dot64(crn_vec3 a, crn_vec3 b)
{
    return crn_product_add(crn_product_add(crn_product(a.v[0], b.v[0]), a.v[1], b.v[1]), a.v[2], b.v[2]);
}

/* Returns the dot product of a vector and a unit vector, rounded once. Format: Qa . Q30 -> Qa in steps of 4
 * LSB. Overflow: impossible while the vector's length is below 2^31 (1 - 2^-9). Error: 2 LSB. */
static inline int32_t crn_vec3_dot_unit(const crn_vec3 *a, const crn_vec3 *unit_q30)
{
    return crn_round_high64(crn_vec3_dot64(*a, *unit_q30)) * 4;
}

/* Returns the difference a b - c d, computed from the rounded high words of the products. Format: Qa x Q30 ->
 * Qa in steps of 4 LSB. Error: 4 LSB. */
static inline int32_t crn_minor_unit(int32_t a, int32_t b_q30, int32_t c, int32_t d_q30)
{
    return crn_mulh_sub(crn_mulh(a, b_q30), c, d_q30) * 4;
}

/* Returns the cross product with a unit vector on the left. Format: Q30 x Qa -> Qa in steps of 4 LSB.
 * Overflow: impossible while the other's length is below 2^31 (1 - 2^-9). Error: 4 LSB. */
static inline crn_vec3 crn_vec3_cross_unit(const crn_vec3 *unit_q30, const crn_vec3 *a)
{
    const int32_t *u = unit_q30->v;
    return crn_vec3_make(crn_minor_unit(a->v[2], u[1], a->v[1], u[2]),
                         crn_minor_unit(a->v[0], u[2], a->v[2], u[0]),
                         crn_minor_unit(a->v[1], u[0], a->v[0], u[1]));
}

/* Cross product. Format: Qa x Qb -> Q(a+b-n), rounded, 1 <= n <= 63, 64-bit intermediate. Overflow:
 * saturates. Error: 1/2 LSB. */
crn_vec3 crn_vec3_cross(crn_vec3 a, crn_vec3 b, unsigned n);

/* Scale to unit length. Format: any Q -> Q30. Overflow: only the result *length can overflow, and it
 * saturates at its largest value. The error of the direction is at most 3 LSB of Q30 per component for a
 * vector of any length >= 1 LSB; the relative error of *length is at most 1/2 LSB + 2^-29. For a zero vector,
 * the returned direction is `fallback` and the length is 0. If `length` is not NULL, *length receives the
 * length in the input's format. */
crn_vec3 crn_vec3_normalise(crn_vec3 a, crn_vec3 fallback, int32_t *length);

#endif
