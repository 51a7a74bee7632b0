/* This file has the vector functions that are too long to be inline; vector.h states formats and bounds. */
#include "firmware/core/vector.h"

/* Returns a b - c d, rounded once. Overflow is impossible before saturation, because |a b - c d| <= 2^63 -
 * 2^31. To round the result, the code shifts first and then adds the highest bit that the shift dropped, so
 * that the addition cannot overflow. */
static int32_t minor_2x2(int32_t a, int32_t b, int32_t c, int32_t d, unsigned n)
{
    int64_t difference = (int64_t)a * b - (int64_t)c * d;
    return crn_sat32(crn_asr64(difference, n) + (crn_asr64(difference, n - 1) & 1));
}

crn_vec3 crn_vec3_cross(crn_vec3 a, crn_vec3 b, unsigned n)
{
    return crn_vec3_make(minor_2x2(a.v[1], b.v[2], a.v[2], b.v[1], n),
                         minor_2x2(a.v[2], b.v[0], a.v[0], b.v[2], n),
                         minor_2x2(a.v[0], b.v[1], a.v[1], b.v[0], n));
}

crn_vec3 crn_vec3_normalise(crn_vec3 a, crn_vec3 fallback, int32_t *length)
{
    /* The square of each component is at most 2^62, so the sum of three squares fits an unsigned 64-bit
     * number. */
    uint64_t square = (uint64_t)((int64_t)a.v[0] * a.v[0]) + (uint64_t)((int64_t)a.v[1] * a.v[1]) +
                      (uint64_t)((int64_t)a.v[2] * a.v[2]);
    if (square == 0) {
        if (length != NULL) {
            *length = 0;
        }
        return fallback;
    }
    /* The length |a| of a vector follows from its square = m 2^(32 - shift), with the mantissa m in [2^30,
     * 2^32): with y = 1/sqrt(m), it is |a| = 2^(32 - shift/2) / y. */
    unsigned shift = crn_clz64(square) & ~1u;
    uint32_t m_q32 = (uint32_t)((square << shift) >> 32);
    int32_t y_q30 = crn_rsqrt_q30(m_q32);
    unsigned drop = 32 - shift / 2;
    if (length != NULL) {
        uint64_t root = (uint64_t)m_q32 * (uint64_t)y_q30;
        unsigned root_drop = 30 + shift / 2;
        uint64_t rounded = (root + ((uint64_t)1 << (root_drop - 1))) >> root_drop;
        *length = rounded > INT32_MAX ? INT32_MAX : (int32_t)rounded;
    }
    return crn_vec3_make(crn_mul(a.v[0], y_q30, drop), crn_mul(a.v[1], y_q30, drop),
                         crn_mul(a.v[2], y_q30, drop));
}
