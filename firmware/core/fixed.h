/* This header and fixed.c implement the core's fixed-point operations, which shift, round and saturate
 * numbers.
 *
 * The suffix of a variable's name is its number format: `x_m_q30` is a length in metres times 2^30, stored in
 * an int32_t. The comment of every function says what the function does, which number formats it uses
 * ("Format"), what happens when a result does not fit ("Overflow"), and how large the error may be ("Error").
 * The error bound is in LSB of the result and is checked against double in firmware/tests/test_fixed.c.
 * Unless its comment says "floor", a function rounds to the nearest value, and ties towards +infinity, by an
 * addition and an arithmetic shift. The Cortex-M7 DSP instructions (SMMULR) round in the same way, so the
 * results are identical on every processor. */
#ifndef CRN_FIXED_H
#define CRN_FIXED_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define CRN_ONE_Q30 ((int32_t)1 << 30)

/* Shifts a possibly negative value right, arithmetically. Format: 64 bit -> 64 bit, floor(a / 2^n), 0 <= n <=
 * 63. Overflow: none. Error: exact floor. C11 leaves the meaning of >> for a negative value to the
 * implementation; the test asserts that the compiler shifts arithmetically. */
static inline int64_t crn_asr64(int64_t a, unsigned n)
{
    return a >> n;
}

/* Shifts a possibly negative 32-bit value right arithmetically, for 0 <= n <= 31, like crn_asr64 for 64 bits.
 */
static inline int32_t crn_asr32(int32_t a, unsigned n)
{
    return a >> n;
}

/* Rounding shift right. Format: floor(a / 2^n + 1/2), 1 <= n <= 62. Overflow: |a| must be < 2^63 - 2^(n-1).
 * Error: 1/2 LSB. */
static inline int64_t crn_rshift_round64(int64_t a, unsigned n)
{
    return (a + ((int64_t)1 << (n - 1))) >> n;
}

/* Saturates to 32 bits. Format: int64 -> int32. Overflow: saturates. Error: none in range. */
static inline int32_t crn_sat32(int64_t a)
{
    int32_t low = (int32_t)(uint32_t)(uint64_t)a;
    if (low == a) { /* one comparison for the usual case */
        return low;
    }
    return a < 0 ? INT32_MIN : INT32_MAX;
}

/* The Cortex-M7's DSP instructions perform some of the following operations in one step; on other processors,
 * C code computes the same values. */
#if defined(__ARM_FEATURE_DSP) && defined(__thumb__)
#define CRN_HIGH_WORDS_BY_DSP 1
#else
#define CRN_HIGH_WORDS_BY_DSP 0
#endif

/* These functions return the saturating sum and difference of two numbers (instructions QADD, QSUB). Format:
 * same format in and out. Overflow: saturates. Error: exact in range. */
static inline int32_t crn_add_sat(int32_t a, int32_t b)
{
#if CRN_HIGH_WORDS_BY_DSP
    int32_t sum;
    __asm__("qadd %0, %1, %2" : "=r"(sum) : "r"(a), "r"(b) : "cc");
    return sum;
#else
    int32_t sum;
    if (!__builtin_add_overflow(a, b, &sum)) {
        return sum;
    }
    return a < 0 ? INT32_MIN : INT32_MAX;
#endif
}
static inline int32_t crn_sub_sat(int32_t a, int32_t b)
{
#if CRN_HIGH_WORDS_BY_DSP
    int32_t difference;
    __asm__("qsub %0, %1, %2" : "=r"(difference) : "r"(a), "r"(b) : "cc");
    return difference;
#else
    int32_t difference;
    if (!__builtin_sub_overflow(a, b, &difference)) {
        return difference;
    }
    return a < 0 ? INT32_MIN : INT32_MAX;
#endif
}

/* Returns a >> n, limited to the range -most .. most. Format: 64 bit -> 32 bit, floor, `most_high` being the
 * high word of `most` << n, 1 <= n <= 31. Overflow: the result is limited, and a bit of `flag` is set in
 * `*flags`. To detect an overflow on a 32-bit machine, the code examines only the high word of the 64-bit
 * number. */
static inline int32_t crn_limit64(int64_t a, unsigned n, int32_t most_high, uint32_t flag, uint32_t *flags)
{
    int64_t most = (int64_t)most_high << (32 - n);
    if (sizeof(void *) > 4) {
        int64_t value = a >> n;
        if ((uint64_t)(value + most) < 2 * (uint64_t)most) {
            return (int32_t)value;
        }
    } else {
        uint32_t high = (uint32_t)((uint64_t)a >> 32);
        if (high + (uint32_t)most_high < 2 * (uint32_t)most_high) {
            return (int32_t)(high << (32 - n) | (uint32_t)a >> n);
        }
    }
    *flags |= flag;
    return (int32_t)(a < 0 ? -most : (most > INT32_MAX ? INT32_MAX : most));
}

/* a b, exactly. On the Cortex-M7 the product of two 32-bit numbers takes one SMULL instruction, even where
 * the compiler would treat a widened operand as a 64-bit value. */
static inline int64_t crn_product(int32_t a, int32_t b)
{
#if CRN_HIGH_WORDS_BY_DSP
    int64_t product;
    __asm__("smull %Q0, %R0, %1, %2" : "=r"(product) : "r"(a), "r"(b));
    return product;
#else
    return (int64_t)a * b;
#endif
}

/* Returns sum + a b (instruction SMLAL). Overflow: the caller ensures that the sum fits 64 bits. */
static inline int64_t crn_product_add(int64_t sum, int32_t a, int32_t b)
{
#if CRN_HIGH_WORDS_BY_DSP
    __asm__("smlal %Q0, %R0, %1, %2" : "+r"(sum) : "r"(a), "r"(b));
    return sum;
#else
    return sum + (int64_t)a * b;
#endif
}

/* Returns the product of two values, rounded and saturated once. Format: Qa x Qb -> Q(a+b-n), 64-bit
 * intermediate, 1 <= n <= 62. Overflow: saturates. Error: 1/2 LSB in range. To detect an overflow on a 32-bit
 * machine, the code examines only the upper word of the 64-bit number. */
static inline int32_t crn_mul(int32_t a, int32_t b, unsigned n)
{
    int64_t sum = crn_product(a, b) + ((int64_t)1 << (n - 1));
    if (sizeof(void *) > 4 || n > 31) {
        return crn_sat32(sum >> n);
    }
    int32_t high = (int32_t)(uint32_t)((uint64_t)sum >> 32);
    if (((uint32_t)high + ((uint32_t)1 << (n - 1))) >> n != 0) {
        return high < 0 ? INT32_MIN : INT32_MAX;
    }
    return (int32_t)((uint32_t)high << (32 - n) | (uint32_t)sum >> n);
}

/* Product with a Q30 factor. Format: Qa x Q30 -> Qa. Overflow: the result saturates, which happens only when
 * |b| > 1. Error: 1/2 LSB. */
static inline int32_t crn_mul_q30(int32_t a, int32_t b_q30)
{
    return crn_mul(a, b_q30, 30);
}

/* Returns the rounded high word of a product (instruction SMMULR). Format: Qa x Qb -> Q(a+b-32). Overflow:
 * impossible, |a*b| <= 2^62. Error: 1/2 LSB. */
static inline int32_t crn_mulh(int32_t a, int32_t b)
{
#if CRN_HIGH_WORDS_BY_DSP
    int32_t high;
    __asm__("smmulr %0, %1, %2" : "=r"(high) : "r"(a), "r"(b));
    return high;
#else
    return (int32_t)(((int64_t)a * b + ((int64_t)1 << 31)) >> 32);
#endif
}

/* Returns the sum of `sum` and the rounded high word of a b (instruction SMMLAR). Format: sum in Q(a+b-32).
 * Overflow: the caller ensures that the sum fits 32 bits. Error: 1/2 LSB. */
static inline int32_t crn_mulh_add(int32_t sum, int32_t a, int32_t b)
{
#if CRN_HIGH_WORDS_BY_DSP
    int32_t high;
    __asm__("smmlar %0, %1, %2, %3" : "=r"(high) : "r"(a), "r"(b), "r"(sum));
    return high;
#else
    return sum + crn_mulh(a, b);
#endif
}

/* Returns `sum` less the rounded high word of a b (instruction SMMLSR). The rounding, format and overflow are
 * those of crn_mulh_add. Error: 1/2 LSB. */
static inline int32_t crn_mulh_sub(int32_t sum, int32_t a, int32_t b)
{
#if CRN_HIGH_WORDS_BY_DSP
    int32_t high;
    __asm__("smmlsr %0, %1, %2, %3" : "=r"(high) : "r"(a), "r"(b), "r"(sum));
    return high;
#else
    return sum + (int32_t)((((int64_t)1 << 31) - (int64_t)a * b) >> 32);
#endif
}

/* Returns the product of a number and a factor of at most one, without saturation. Components of unit
 * vectors, sines and ratios are examples of factors of at most one. Format: Qa x Q30 -> Qa in steps of 4 LSB,
 * the high word shifted back. Overflow is impossible while |b| <= 1 + 2^-10 and |a| < 2^31 (1 - 2^-9); the
 * caller ensures both conditions. Error: 2 LSB. */
static inline int32_t crn_scale_q30(int32_t a, int32_t b_q30)
{
    return crn_mulh(a, b_q30) * 4;
}

/* High word. Format: 64 bit -> 32 bit, floor(a / 2^32). The casts to 32 bits keep a 32-bit compiler from
 * computing with 64 bits. */
static inline int32_t crn_high64(int64_t a)
{
    return (int32_t)(uint32_t)((uint64_t)a >> 32);
}

/* High word, rounded. Format: 64 bit -> 32 bit, floor(a / 2^32 + 1/2). Overflow: |a| must be below 2^63 -
 * 2^31. On a 32-bit machine the function rounds by adding the low word's top bit to the high word. Error: 1/2
 * LSB. */
static inline int32_t crn_round_high64(int64_t a)
{
    if (sizeof(void *) > 4) {
        return (int32_t)((a + ((int64_t)1 << 31)) >> 32);
    }
    return crn_high64(a) + (int32_t)((uint32_t)a >> 31);
}

/* Returns the low 32 bits of a >> n for 1 <= n <= 31. Format: 64 bit -> 32 bit, floor. Overflow: the bits
 * above the 32nd are lost; the caller ensures that there are no such bits. Error: exact floor. A 32-bit
 * machine needs three instructions for crn_narrow64, and nine instructions for a full 64-bit shift. */
static inline int32_t crn_narrow64(int64_t a, unsigned n)
{
    if (sizeof(void *) > 4) {
        return (int32_t)(a >> n);
    }
    return (int32_t)((uint32_t)((uint64_t)a >> 32) << (32 - n) | (uint32_t)a >> n);
}

/* Returns the number of leading zero bits of an integer. For the integer zero, the result is the width of the
 * type. */
static inline unsigned crn_clz32(uint32_t a)
{
    return a == 0 ? 32u : (unsigned)__builtin_clz(a);
}
static inline unsigned crn_clz64(uint64_t a)
{
    return a == 0 ? 64u : (unsigned)__builtin_clzll(a);
}

/* Describes one interval of a falling piecewise linear function by the value at the interval's start and by
 * the decrease over the interval, both in Q30. */
typedef struct crn_line_q30 {
    uint32_t value;
    uint32_t drop;
} crn_line_q30;

/* The tables' constants are defined in fixed_tables.c, which tools/check/make_tables.py writes. */
extern const crn_line_q30 crn_reciprocal_lines[128];
extern const crn_line_q30 crn_rsqrt_lines[192];
extern const int32_t crn_asin_coefficients_q31[7];

/* Returns the value of a piecewise linear function within one of its intervals, at the fraction `fraction` (a
 * number of `bits` bits) of the interval. Format: Q30. Overflow: impossible (drop < 2^25). The relative error
 * of the interpolated value is that of the table, at most 2^-16.4; the Newton step of the caller squares this
 * error. */
static inline uint32_t crn_line_at(const crn_line_q30 *line, uint32_t fraction, unsigned bits)
{
    return line->value - (uint32_t)(((uint64_t)line->drop * fraction) >> bits);
}

/* Returns the reciprocal of a positive normalised mantissa, by a linear table and one Newton step y + y (1 -
 * m y). No divide. Format: m in [2^30, 2^31) read as Q31 in [0.5, 1) -> Q30 in (1, 2]. The caller normalises;
 * another m gives a wrong number but still reads inside the table. Overflow: only the mantissa m = 2^30 has
 * the result 1/0.5 = 2, which does not fit, so the function returns 2^31 - 1 for it. The error of the
 * reciprocal is at most 1 LSB of Q30 (0.63 LSB in the test). */
static inline int32_t crn_reciprocal_q30(uint32_t m_q31)
{
    const crn_line_q30 *line = &crn_reciprocal_lines[(m_q31 >> 23) & 127u];
    int32_t y_q30 = (int32_t)crn_line_at(line, m_q31 & 0x7fffffu, 23);
    /* |miss| < 2^-16 */
    int32_t miss_q47 = (int32_t)((int64_t)(((uint64_t)1 << 61) - (uint64_t)m_q31 * (uint32_t)y_q30) >> 14);
    int32_t step = crn_asr32((int32_t)(((int64_t)y_q30 * miss_q47 + ((int64_t)1 << 46)) >> 32), 15);
    uint32_t better = (uint32_t)((int64_t)y_q30 + step); /* at most 2^31 */
    return better > INT32_MAX ? INT32_MAX : (int32_t)better;
}

/* Returns the reciprocal square root of a mantissa, by a linear table and one Newton step y + y (1 - m y y) /
 * 2. No divide. Format: m in [2^30, 2^32) read as Q32 in [0.25, 1) -> Q30 in [1, 2]. The caller normalises: a
 * smaller m reads before the table. Overflow: only the mantissa m = 2^30 has the result 1/sqrt(0.25) = 2,
 * which does not fit, so the function returns 2^31 - 1 for it. The error of the reciprocal square root is at
 * most 1.5 LSB of Q30 (1.39 LSB in the test). */
static inline int32_t crn_rsqrt_q30(uint32_t m_q32)
{
    const crn_line_q30 *line = &crn_rsqrt_lines[(m_q32 >> 24) - 64u];
    uint32_t y_q30 = crn_line_at(line, m_q32 & 0xffffffu, 24);
    uint32_t root_q31 = (uint32_t)(((uint64_t)m_q32 * y_q30 + (1u << 30)) >> 31); /* m y: about sqrt(m) */
    /* |miss| < 2^-15 */
    int32_t miss_q46 = (int32_t)((int64_t)(((uint64_t)1 << 61) - (uint64_t)root_q31 * y_q30) >> 15);
    int32_t step = crn_asr32((int32_t)(((int64_t)(int32_t)y_q30 * miss_q46 + ((int64_t)1 << 46)) >> 32), 15);
    uint32_t better = (uint32_t)((int64_t)y_q30 + step); /* at most 2^31 */
    return better > INT32_MAX ? INT32_MAX : (int32_t)better;
}

/* Returns the square root of a 64-bit integer. Format: Q2n -> Qn, rounded. Overflow: the result saturates at
 * 2^31 - 1. The error of the result is at most 1/2 LSB plus 2^-29 of the square root; the root of 0 is 0. */
int32_t crn_sqrt64(uint64_t a);

/* Returns the quotient of two 64-bit integers; the function computes one bit in each of 64 steps. The
 * function crn_divide_u64 is slow but needs no library function for division; it is for set-up and for
 * quotients that are rarely computed. Format: floor(a / b). b = 0 gives UINT64_MAX. Error: exact floor. */
uint64_t crn_divide_u64(uint64_t a, uint64_t b);

/* Computes sine and cosine of a binary angle. The function reduces the angle to the nearest quarter turn, and
 * uses the Taylor series up to x^11 and x^12 for the remaining angle. Format: one turn = 2^32 -> Q30.
 * Overflow: impossible, |result| <= 2^30. The error of sine and cosine is at most 1.5 LSB of Q30 (1.27 LSB in
 * the test). */
void crn_sincos_turn32(uint32_t angle_turn32, int32_t *sin_q30, int32_t *cos_q30);

/* Returns the arc sine, by a polynomial for |a| <= 1/2, and as pi/2 - 2 asin(sqrt((1 - |a|)/2)) for |a| >
 * 1/2. Format: Q30 in [-1, 1] (beyond: clamped) -> Q29 radians in [-pi/2, pi/2]. Overflow: impossible. The
 * error of the arc sine is at most 1.5 LSB of Q29, that is, 2.8e-9 rad (1.37 LSB in the test). */
int32_t crn_asin_q29(int32_t a_q30);

#endif
