/* Stands in for operations of gcc that Frama-C does not know by these names; tools/safety/eva.py includes
 * this file before every source. The sums and differences have Frama-C's own contracts. The number of leading
 * zeros is computed by comparisons, so that the analysis treats each number of zeros as a case of its own. */
#ifndef CRN_EVA_BUILTINS_H
#define CRN_EVA_BUILTINS_H

#define __builtin_add_overflow __builtin_sadd_overflow
#define __builtin_sub_overflow __builtin_ssub_overflow
#define __builtin_clz eva_leading_zeros_32
#define __builtin_clzll eva_leading_zeros_64

static inline int eva_leading_zeros_32(unsigned value)
{
    int zeros = 0;
    while (zeros < 31 && value < 1u << (31 - zeros)) zeros++;
    return zeros;
}

static inline int eva_leading_zeros_64(unsigned long long value)
{
    int zeros = 0;
    while (zeros < 63 && value < 1ull << (63 - zeros)) zeros++;
    return zeros;
}

#endif
