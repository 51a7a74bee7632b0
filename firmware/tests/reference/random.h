/* This header provides seeded random numbers for tests, by SplitMix64 (Steele, Lea, Flood 2014). A seed
 * reproduces a run. */
#ifndef CRN_REFERENCE_RANDOM_H
#define CRN_REFERENCE_RANDOM_H

#include <stdint.h>

typedef struct reference_random {
    uint64_t state;
} reference_random;

static inline reference_random reference_random_seed(uint64_t seed)
{
    reference_random random = {seed};
    return random;
}

static inline uint64_t reference_random_next(reference_random *random)
{
    uint64_t z = random->state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/* Returns a sufficiently uniform number in 0 .. limit - 1 (limit < 2^32). */
static inline unsigned reference_random_below(reference_random *random, unsigned limit)
{
    return (unsigned)(((reference_random_next(random) >> 32) * limit) >> 32);
}

/* Returns a random signed value; the magnitudes from 0 to 2^31 are equally likely on a logarithmic scale. */
static inline int32_t reference_random_scaled32(reference_random *random)
{
    int64_t wide = (int64_t)(reference_random_next(random) >> 32) - ((int64_t)1 << 31);
    return (int32_t)(wide >> reference_random_below(random, 32));
}

#endif
