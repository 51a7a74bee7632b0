/* This file has the fixed-point functions that are too long to be inline; fixed.h states their formats,
 * overflow and error bounds. */
#include "firmware/core/fixed.h"

int32_t crn_sqrt64(uint64_t a)
{
    if (a == 0) {
        return 0;
    }
    /* The square root of a = m 2^(32 - shift), with the mantissa m in [2^30, 2^32), is sqrt(a) = m rsqrt(m)
     * 2^-(30 + shift/2), where rsqrt(m) is 1/sqrt(m). */
    unsigned shift = crn_clz64(a) & ~1u;
    uint64_t m_q32 = (a << shift) >> 32;
    uint64_t root = m_q32 * (uint64_t)crn_rsqrt_q30((uint32_t)m_q32);
    unsigned drop = 30 + shift / 2;
    uint64_t rounded = (root + ((uint64_t)1 << (drop - 1))) >> drop;
    return rounded > INT32_MAX ? INT32_MAX : (int32_t)rounded;
}

uint64_t crn_divide_u64(uint64_t a, uint64_t b)
{
    if (b == 0) {
        return UINT64_MAX;
    }
    uint64_t quotient = 0;
    uint64_t rest = 0;
    for (int bit = 63; bit >= 0; bit--) {
        /* Before each step, `rest` is no greater than the number formed by the top (63 - bit) bits of `a`, so
         * the shift loses no bits. */
        rest = (rest << 1) | ((a >> bit) & 1u);
        if (rest >= b) {
            rest -= b;
            quotient |= (uint64_t)1 << bit;
        }
    }
    return quotient;
}

/* Horner's scheme. Format: coefficients and z Q31, |value| < 1 throughout -> Q31. The rounding error is 1/2
 * LSB of Q31 per step. */
static int32_t polynomial_q31(const int32_t *coefficients, int count, int32_t z_q31)
{
    int32_t value = coefficients[count - 1];
    for (int i = count - 2; i >= 0; i--) {
        value = coefficients[i] + crn_mul(value, z_q31, 31);
    }
    return value;
}

/* Computes sin x = x + x z p(z) and cos x = 1 - z/2 + z^2 q(z) with two polynomials p and q of z = x^2, for
 * |x| <= pi/4. */
static void sincos_octant(int32_t x_q31, int32_t *sin_q30, int32_t *cos_q30)
{
    /* -1/3!, 1/5!, -1/7!, 1/9!, -1/11! and 1/4!, -1/6!, 1/8!, -1/10!, 1/12! times 2^31 */
    static const int32_t sin_q31[5] = {-357913941, 17895697, -426088, 5918, -54};
    static const int32_t cos_q31[5] = {89478485, -2982616, 53261, -592, 4};
    int32_t z_q31 = crn_mul(x_q31, x_q31, 31);
    int32_t sin_rest_q31 = crn_mul(crn_mul(polynomial_q31(sin_q31, 5, z_q31), z_q31, 31), x_q31, 31);
    int32_t cos_rest_q31 = crn_mul(crn_mul(polynomial_q31(cos_q31, 5, z_q31), z_q31, 31), z_q31, 31);
    *sin_q30 = (int32_t)crn_rshift_round64((int64_t)x_q31 + sin_rest_q31, 1);
    *cos_q30 = CRN_ONE_Q30 - (int32_t)crn_rshift_round64((int64_t)z_q31 - 2 * (int64_t)cos_rest_q31, 2);
}

void crn_sincos_turn32(uint32_t angle_turn32, int32_t *sin_q30, int32_t *cos_q30)
{
    /* Splits the angle into the nearest quarter turn and a remainder of -1/8 .. 1/8 turn. */
    const int32_t pi_q29 = 1686629713;
    uint32_t quarter = (angle_turn32 + ((uint32_t)1 << 29)) >> 30;
    uint32_t left_turn32 = angle_turn32 - (quarter << 30);
    int32_t left = left_turn32 > INT32_MAX ? -(int32_t)(~left_turn32) - 1 : (int32_t)left_turn32;
    int32_t sine = 0;
    int32_t cosine = 0;
    /* The remainder of the angle, in radians, is x = 2 pi left / 2^32, which is left * pi in Q31. */
    sincos_octant(crn_mul(left, pi_q29, 29), &sine, &cosine);

    switch (quarter) {
    case 0:
        *sin_q30 = sine, *cos_q30 = cosine;
        break;
    case 1:
        *sin_q30 = cosine, *cos_q30 = -sine;
        break;
    case 2:
        *sin_q30 = -sine, *cos_q30 = -cosine;
        break;
    default:
        *sin_q30 = -cosine, *cos_q30 = sine;
        break;
    }
}

/* Computes asin x = x + x z p(z) with a polynomial p of z = x^2, for 0 <= x <= 1/2. Every x from 0 to 1/2
 * fits Q31. Format: Q31 -> Q31 radians, at most pi/6. */
static int32_t asin_small_q31(int32_t x_q31)
{
    int32_t z_q31 = crn_mul(x_q31, x_q31, 31);
    int32_t rest_q31 = crn_mul(polynomial_q31(crn_asin_coefficients_q31, 7, z_q31), z_q31, 31);
    return x_q31 + crn_mul(rest_q31, x_q31, 31);
}

int32_t crn_asin_q29(int32_t a_q30)
{
    const int64_t half_pi_q31 = 3373259426;
    int64_t size_q30 = a_q30 < 0 ? -(int64_t)a_q30 : a_q30;
    if (size_q30 > CRN_ONE_Q30) {
        size_q30 = CRN_ONE_Q30;
    }
    int64_t angle_q31 = 0;
    if (size_q30 <= CRN_ONE_Q30 / 2) {
        angle_q31 = asin_small_q31((int32_t)(size_q30 * 2));
    } else {
        /* Computes sqrt((1 - a)/2). The bits of 1 - a in Q30 are also the bits of (1 - a)/2 in Q31; when this
         * number is shifted to Q62, its square root is in Q31. */
        int32_t root_q31 = crn_sqrt64((uint64_t)(CRN_ONE_Q30 - size_q30) << 31);
        angle_q31 = half_pi_q31 - 2 * (int64_t)asin_small_q31(root_q31);
    }
    int32_t angle_q29 = (int32_t)crn_rshift_round64(angle_q31, 2);
    return a_q30 < 0 ? -angle_q29 : angle_q29;
}
