/* This header computes with the three components of a vector, or with a row of a 3x3 block, in one step of a
 * processor with 256-bit registers. Each component has a lane of 64 bits. The fourth lane of a vector in
 * space is not used, and its value has no meaning.
 *
 * A number of 32 bits occupies the lower half of its lane. Where a comment says so, the lane holds the number
 * with its sign; elsewhere the upper half has no meaning, because neither a product nor a sum modulo 2^32
 * depends on it. For the same reason, a right shift of which only 32 bits are used may be a logical one.
 *
 * Only x86-64 processors with AVX2 have lanes. One program runs on all x86-64 processors, because
 * crn_lanes_present() asks the processor. Every result equals that of the other code, bit for bit. */
#ifndef CRN_CORE_LANES_H
#define CRN_CORE_LANES_H

#include "firmware/core/vector.h"

#if defined(__x86_64__) && (defined(__clang__) || (defined(__GNUC__) && __GNUC__ >= 12))
#define CRN_HAS_LANES 1
#else
#define CRN_HAS_LANES 0
#endif

#if CRN_HAS_LANES

#define CRN_LANES_TARGET __attribute__((target("avx2,bmi,bmi2,lzcnt")))
#define CRN_LANES_INLINE static inline __attribute__((always_inline, target("avx2,bmi,bmi2,lzcnt")))

typedef int64_t crn_lanes __attribute__((vector_size(32)));
typedef uint64_t crn_lanes_u64 __attribute__((vector_size(32)));
typedef int32_t crn_lanes_i32 __attribute__((vector_size(32)));
typedef int32_t crn_words4 __attribute__((vector_size(16)));
typedef uint32_t crn_words4_u32 __attribute__((vector_size(16)));

/* Returns whether the processor has the instructions of CRN_LANES_TARGET, and the operating system keeps
 * their registers. */
bool crn_lanes_present(void);

CRN_LANES_INLINE crn_lanes crn_lanes_all(int64_t value)
{
    return (crn_lanes){value, value, value, value};
}

/* Reads and writes three numbers in 128 bits. The 16 bytes at `from` must be readable; 12 are written. */
CRN_LANES_INLINE crn_words4 crn_words_read(const void *from)
{
    crn_words4 words;
    __builtin_memcpy(&words, from, sizeof words);
    return words;
}
CRN_LANES_INLINE void crn_words_write3(int32_t *to, crn_words4 words)
{
    __builtin_memcpy(to, &words, 8);
    to[2] = words[2];
}

/* Returns the lower halves of the lanes. */
CRN_LANES_INLINE crn_words4 crn_lanes_halves(crn_lanes a)
{
    const crn_lanes_i32 halves = (crn_lanes_i32)a;
    return __builtin_shufflevector(halves, halves, 0, 2, 4, 6);
}

/* Reads three numbers, with their sign. The 16 bytes at `from` must be readable. */
CRN_LANES_INLINE crn_lanes crn_lanes_read(const void *from)
{
    return __builtin_convertvector(crn_words_read(from), crn_lanes);
}

/* Writes the lower halves of all four lanes, or of the first three. */
CRN_LANES_INLINE void crn_lanes_write(void *to, crn_lanes a)
{
    const crn_words4 words = crn_lanes_halves(a);
    __builtin_memcpy(to, &words, sizeof words);
}
CRN_LANES_INLINE void crn_lanes_write3(int32_t *to, crn_lanes a)
{
    crn_words_write3(to, crn_lanes_halves(a));
}

/* Returns the exact products of the lower halves, which are signed. */
CRN_LANES_INLINE crn_lanes crn_lanes_product(crn_lanes a, crn_lanes b)
{
    return (crn_lanes)__builtin_ia32_pmuldq256((crn_lanes_i32)a, (crn_lanes_i32)b);
}

/* Shifts right, logically. */
CRN_LANES_INLINE crn_lanes crn_lanes_shift(crn_lanes a, unsigned n)
{
    return (crn_lanes)((crn_lanes_u64)a >> n);
}

/* Shifts right, arithmetically, for 1 <= n <= 63. A bias makes the number positive. */
CRN_LANES_INLINE crn_lanes crn_lanes_asr(crn_lanes a, unsigned n)
{
    return crn_lanes_shift(a ^ crn_lanes_all(INT64_MIN), n) - crn_lanes_all((int64_t)1 << (63 - n));
}

/* Returns the rounded high words of the products, as crn_mulh() does. */
CRN_LANES_INLINE crn_lanes crn_lanes_mulh(crn_lanes a, crn_lanes b)
{
    return crn_lanes_shift(crn_lanes_product(a, b) + crn_lanes_all((int64_t)1 << 31), 32);
}

/* Returns `a` where the lane of `mask` is -1, and `b` where it is 0. */
CRN_LANES_INLINE crn_lanes crn_lanes_choose(crn_lanes mask, crn_lanes a, crn_lanes b)
{
    return (mask & a) | (~mask & b);
}

/* Limits the lanes to -most .. most. */
CRN_LANES_INLINE crn_lanes crn_lanes_clamp(crn_lanes a, int64_t most)
{
    const crn_lanes high = crn_lanes_all(most), low = crn_lanes_all(-most);
    return crn_lanes_choose(a > high, high, crn_lanes_choose(low > a, low, a));
}

/* Limits the lanes to 32 bits, as crn_sat32() does. */
CRN_LANES_INLINE crn_lanes crn_lanes_sat32(crn_lanes a)
{
    const crn_lanes high = crn_lanes_all(INT32_MAX), low = crn_lanes_all(INT32_MIN);
    return crn_lanes_choose(a > high, high, crn_lanes_choose(low > a, low, a));
}

/* Returns the products in steps of 4 LSB, as crn_scale_q30() does, with their sign. */
CRN_LANES_INLINE crn_lanes crn_lanes_scale_q30(crn_lanes a, crn_lanes b_q30)
{
    const crn_lanes product = crn_lanes_product(a, b_q30) + crn_lanes_all((int64_t)1 << 31);
    return (crn_lanes)((crn_lanes_u64)crn_lanes_asr(product, 32) << 2);
}

/* Returns the cross product with a unit vector on the left, as crn_vec3_cross_unit() does. */
CRN_LANES_INLINE crn_lanes crn_lanes_cross_unit(crn_lanes unit_q30, crn_lanes a)
{
    const crn_lanes first = crn_lanes_mulh(__builtin_shufflevector(a, a, 2, 0, 1, 3),
                                           __builtin_shufflevector(unit_q30, unit_q30, 1, 2, 0, 3));
    const crn_lanes second = crn_lanes_product(__builtin_shufflevector(a, a, 1, 2, 0, 3),
                                               __builtin_shufflevector(unit_q30, unit_q30, 2, 0, 1, 3));
    const crn_lanes less = crn_lanes_shift(crn_lanes_all((int64_t)1 << 31) - second, 32);
    return (crn_lanes)((crn_lanes_u64)(first + less) << 2);
}

#endif

#endif
