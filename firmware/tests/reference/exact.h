/* This header has exact integer arithmetic in 128 bits, with which the fixed-point tests compare their
 * results. */
#ifndef CRN_REFERENCE_EXACT_H
#define CRN_REFERENCE_EXACT_H

#include <stdint.h>

__extension__ typedef __int128 reference_wide;

/* Returns floor(a / 2^n) by a division, so that the function does not rely on the right shift of a negative
 * value. */
static inline reference_wide reference_floor_shift(reference_wide a, unsigned n)
{
    reference_wide unit = (reference_wide)1 << n;
    reference_wide quotient = a / unit;
    return a % unit < 0 ? quotient - 1 : quotient;
}

/* Returns floor(a / 2^n + 1/2), which rounds to the nearest value and ties upwards. */
static inline reference_wide reference_round_shift(reference_wide a, unsigned n)
{
    return reference_floor_shift(a + ((reference_wide)1 << (n - 1)), n);
}

static inline int32_t reference_saturated32(reference_wide a)
{
    return a > INT32_MAX ? INT32_MAX : a < INT32_MIN ? INT32_MIN : (int32_t)a;
}

#endif
