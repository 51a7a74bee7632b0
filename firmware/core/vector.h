/* Three-component vectors in fixed point. A vector's format is that of its components and ends its name.
 * May include: fixed.h. Called by: rod, lumen, contact. */
#ifndef SELD_VECTOR_H
#define SELD_VECTOR_H

#include "firmware/core/fixed.h"

typedef struct seld_vec3 {
    int32_t v[3];
} seld_vec3;

static inline seld_vec3 seld_vec3_make(int32_t x, int32_t y, int32_t z)
{
    seld_vec3 r = {{x, y, z}};
    return r;
}

/* Format: same in and out. Overflow: saturates. */
static inline seld_vec3 seld_vec3_add(seld_vec3 a, seld_vec3 b)
{
    return seld_vec3_make(seld_add_sat(a.v[0], b.v[0]), seld_add_sat(a.v[1], b.v[1]),
                          seld_add_sat(a.v[2], b.v[2]));
}
static inline seld_vec3 seld_vec3_sub(seld_vec3 a, seld_vec3 b)
{
    return seld_vec3_make(seld_sub_sat(a.v[0], b.v[0]), seld_sub_sat(a.v[1], b.v[1]),
                          seld_sub_sat(a.v[2], b.v[2]));
}

/* Raw dot product. Format: Qa . Qb -> Q(a+b) in 64 bits. Overflow: impossible while the components of both
 * stay below 2^31 * 0.81 (3 * 0.81^2 < 2) or those of one within +-2^30 (3 * 2^61 < 2^63). Error: exact. */
static inline int64_t seld_vec3_dot64(seld_vec3 a, seld_vec3 b)
{
    return (int64_t)a.v[0] * b.v[0] + (int64_t)a.v[1] * b.v[1] + (int64_t)a.v[2] * b.v[2];
}

/* Cross product. Format: Qa x Qb -> Q(a+b-n), rounded, 1 <= n <= 63, 64-bit intermediate. Overflow:
 * saturates. Error: 1/2 LSB. */
seld_vec3 seld_vec3_cross(seld_vec3 a, seld_vec3 b, unsigned n);

/* Scale to unit length. Format: any Q -> Q30. Overflow: none; *length saturates at INT32_MAX. Error: <= 3 LSB
 * of Q30 per component for a vector of any length >= 1 LSB; *length <= 1/2 LSB + 2^-29 relative. A zero
 * vector gives `fallback` and length 0. *length gets the length in the input's format when not NULL. */
seld_vec3 seld_vec3_normalise(seld_vec3 a, seld_vec3 fallback, int32_t *length);

#endif
