/* Fixed-point operations of the core: the only file that shifts, rounds and saturates.
 *
 * A number's format ends its name: `x_m_q30` is metres times 2^30 in an int32_t. Every function says what it does,
 * its Format, what happens on Overflow, and its Error (bound in LSB of the result, checked against double in
 * firmware/tests/test_fixed.c). Rounding is to nearest with ties toward +infinity, written as an addition and an
 * arithmetic shift, which is what the Cortex-M7 DSP instructions (SMMULR) do, so every machine agrees bit for bit.
 *
 * May include: nothing outside this folder. Called by: everything in firmware/core.
 */
#ifndef SELD_FIXED_H
#define SELD_FIXED_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SELD_ONE_Q30 ((int32_t)1 << 30)

/* Arithmetic shift right of a possibly negative value.
 * Format: 64 bit -> 64 bit, floor(a / 2^n), 0 <= n <= 63. Overflow: none. Error: exact floor.
 * C11 leaves >> of a negative value to the implementation; the test asserts that ours shifts arithmetically. */
static inline int64_t seld_asr64(int64_t a, unsigned n)
{
    return a >> n;
}

/* Rounding shift right. Format: floor(a / 2^n + 1/2), 1 <= n <= 62. Overflow: |a| must be < 2^63 - 2^(n-1).
 * Error: 1/2 LSB. */
static inline int64_t seld_rshift_round64(int64_t a, unsigned n)
{
    return (a + ((int64_t)1 << (n - 1))) >> n;
}

/* Saturate to 32 bits. Format: int64 -> int32. Overflow: saturates. Error: none in range. */
static inline int32_t seld_sat32(int64_t a)
{
    if (a > INT32_MAX) {
        return INT32_MAX;
    }
    if (a < INT32_MIN) {
        return INT32_MIN;
    }
    return (int32_t)a;
}

/* Saturating sum and difference. Format: same format in and out. Overflow: saturates. Error: exact in range. */
static inline int32_t seld_add_sat(int32_t a, int32_t b)
{
    return seld_sat32((int64_t)a + b);
}
static inline int32_t seld_sub_sat(int32_t a, int32_t b)
{
    return seld_sat32((int64_t)a - b);
}

/* Product of two values, rounded and saturated once. Format: Qa x Qb -> Q(a+b-n), 64-bit intermediate, 1 <= n <= 62.
 * Overflow: saturates. Error: 1/2 LSB in range. */
static inline int32_t seld_mul(int32_t a, int32_t b, unsigned n)
{
    return seld_sat32(seld_rshift_round64((int64_t)a * b, n));
}

/* Product with a Q30 factor. Format: Qa x Q30 -> Qa. Overflow: saturates (only when |b| > 1). Error: 1/2 LSB. */
static inline int32_t seld_mul_q30(int32_t a, int32_t b_q30)
{
    return seld_mul(a, b_q30, 30);
}

/* High word of a product, rounded: SMMULR. Format: Qa x Qb -> Q(a+b-32). Overflow: impossible, |a*b| <= 2^62.
 * Error: 1/2 LSB. */
static inline int32_t seld_mulh(int32_t a, int32_t b)
{
    return (int32_t)(((int64_t)a * b + ((int64_t)1 << 31)) >> 32);
}

/* Number of leading zero bits of a non-zero value; 32 for zero. */
static inline unsigned seld_clz32(uint32_t a)
{
    return a == 0 ? 32u : (unsigned)__builtin_clz(a);
}

/* Reciprocal of a positive normalised mantissa, by table and Newton, no divide.
 * Format: m in [2^30, 2^31) read as Q31 in [0.5, 1) -> Q30 in (1, 2]. Overflow: m = 2^30 gives 2^31 - 1.
 * Error: <= 2 LSB of Q30. */
int32_t seld_reciprocal_q30(uint32_t m_q31);

/* Reciprocal square root of a mantissa, by table and Newton.
 * Format: m in [2^30, 2^32) read as Q32 in [0.25, 1) -> Q30 in (1, 2]. Overflow: m = 2^30 gives 2^31 - 1.
 * Error: <= 4 LSB of Q30. */
int32_t seld_rsqrt_q30(uint32_t m_q32);

/* Length of a 64-bit square. Format: a (Q2n, a < 2^63) -> floor-ish root in Qn. Overflow: impossible (root < 2^31.5,
 * saturates at INT32_MAX). Error: <= 2 LSB + 2^-28 relative. a = 0 gives 0. */
int32_t seld_sqrt64(uint64_t a);

/* Quotient for set-up code (bit by bit, bounded at 64 steps, no divide helper).
 * Format: floor(a / b). b = 0 gives UINT64_MAX. Error: exact floor. */
uint64_t seld_divide_u64(uint64_t a, uint64_t b);

/* Sine and cosine of a binary angle. Format: one turn = 2^32 -> Q30. Error: <= 4 LSB of Q30. */
void seld_sincos_turn32(uint32_t angle_turn32, int32_t *sin_q30, int32_t *cos_q30);

/* Arc sine by polynomial. Format: Q30 in [-1, 1] -> Q29 radians. Error: <= 2^-22 rad for |a| <= 0.7071; beyond it by
 * the half-angle identity, same bound. */
int32_t seld_asin_q29(int32_t a_q30);

#endif
