/* This file has the functions with fixed-point numbers and vectors that are too long to be inline; fixed.h
 * and vector.h state their formats, overflow and error bounds. */
#include "firmware/core/fixed.h"
#include "firmware/core/lanes.h"
#include "firmware/core/vector.h"

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

/* --- vectors -------------------------------------------------------------------------------------------- */

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

/* --- lanes ---------------------------------------------------------------------------------------------- */

#if CRN_HAS_LANES

typedef struct cpu_words {
    uint32_t a, b, c, d;
} cpu_words;

static cpu_words cpuid(uint32_t leaf, uint32_t subleaf)
{
    cpu_words words;
    __asm__ volatile("cpuid"
                     : "=a"(words.a), "=b"(words.b), "=c"(words.c), "=d"(words.d)
                     : "a"(leaf), "c"(subleaf));
    return words;
}

/* Returns the register that says which registers the operating system keeps. */
static uint32_t kept_registers(void)
{
    uint32_t low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
}

bool crn_lanes_present(void)
{
    enum {
        XSAVE_ENABLED = 1u << 27, /* leaf 1, register c */
        AVX = 1u << 28,
        BMI1 = 1u << 3, /* leaf 7, register b */
        AVX2 = 1u << 5,
        BMI2 = 1u << 8,
        LZCNT = 1u << 5, /* leaf 0x80000001, register c */
        KEPT_256 = 6,    /* xgetbv: the registers of 128 and of 256 bits */
    };
    const uint32_t extended = 0x80000000u;
    if (cpuid(0, 0).a < 7 || cpuid(extended, 0).a <= extended) {
        return false;
    }
    const uint32_t first = cpuid(1, 0).c, seventh = cpuid(7, 0).b;
    if ((first & XSAVE_ENABLED) == 0 || (first & AVX) == 0 || (kept_registers() & KEPT_256) != KEPT_256) {
        return false;
    }
    const uint32_t needed = BMI1 | AVX2 | BMI2;
    return (seventh & needed) == needed && (cpuid(extended + 1, 0).c & LZCNT) != 0;
}

#endif
