/* This header has the arithmetic that the code for hands, haptics and safety shares. */
#ifndef CRN_ARITHMETIC_H
#define CRN_ARITHMETIC_H

#include <stdint.h>

/* Returns value / divisor, rounded towards zero, for divisors of at most 65 535 and |value| < 2^63. A 32-bit
 * processor can divide 64-bit numbers only by a library function of hundreds of instructions. The function
 * crn_quotient needs only three divisions of 32-bit numbers; after the first division, each division gives 16
 * further bits of the quotient. Each remainder is below the 16-bit divisor, so the remainder followed by the
 * next 16 bits of the value fits 32 bits, and the quotient of this number fits 16 bits. */
static inline int64_t crn_quotient(int64_t value, uint32_t divisor)
{
    const uint64_t size = value < 0 ? 0u - (uint64_t)value : (uint64_t)value;
    const uint32_t high = (uint32_t)(size >> 32);
    const uint32_t middle = (high % divisor) << 16 | (uint32_t)(size >> 16 & 0xffff);
    const uint32_t low = (middle % divisor) << 16 | (uint32_t)(size & 0xffff);
    const uint64_t quotient =
        (uint64_t)(high / divisor) << 32 | (uint64_t)(middle / divisor) << 16 | low / divisor;
    return value < 0 ? -(int64_t)quotient : (int64_t)quotient;
}

/* Returns the signed value of a number in two's complement, without a cast whose result the C standard leaves
 * to the compiler. */
static inline int32_t crn_i32_from_u32(uint32_t value)
{
    return value <= INT32_MAX ? (int32_t)value : -(int32_t)(UINT32_MAX - value) - 1;
}

/* Returns the difference a - b of two counters or angles that may wrap. Format: exact while the difference is
 * below 2^31. */
static inline int32_t crn_wrapped_difference(int32_t a, int32_t b)
{
    return crn_i32_from_u32((uint32_t)a - (uint32_t)b);
}

static inline int32_t crn_size_of(int32_t value)
{
    return value < 0 ? -value : value;
}

static inline int32_t crn_limited(int64_t value, int64_t low, int64_t high)
{
    if (value < low) return (int32_t)low;
    if (value > high) return (int32_t)high;
    return (int32_t)value;
}

/* Moves from `present` towards `target`. The magnitude of a force grows by no more than `slew` per tick, and
 * never exceeds the force limit. The magnitude of a force may fall at once, because a force that lasts longer
 * than its cause drives the hand. With a slew limit that also applied to decreasing forces, a handle released
 * at 4 N recoiled at 1.2 m/s during the 80 ms that the force took to end. The requested value `target` may be
 * far out of its range. */
/* Requirement: SR-01, SR-02 */
static inline int32_t crn_approach(int32_t present, int64_t target, int32_t slew, int32_t limit)
{
    const int64_t low = present < 0 ? present : 0, high = present > 0 ? present : 0;
    const int32_t slewed = crn_limited(target, low - slew, high + slew);
    return crn_limited(slewed, -limit, limit);
}

#endif
