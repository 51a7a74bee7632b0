/* Values that the analysis of Frama-C EVA knows only by their range, for the drivers of this folder. Only
 * `make eva` reads these files (tools/safety/eva.py); nothing of them is compiled. docs/safety_code.md
 * explains them. */
#ifndef CRN_EVA_ANY_H
#define CRN_EVA_ANY_H

#include <__fc_builtin.h>
#include <stdbool.h>
#include <stdint.h>

static inline int32_t any_i32(void)
{
    return Frama_C_interval(INT32_MIN, INT32_MAX);
}

static inline uint32_t any_u32(void)
{
    return Frama_C_unsigned_int_interval(0, UINT32_MAX);
}

/* Returns any value from `low` to `high`. */
static inline uint32_t any_from(uint32_t low, uint32_t high)
{
    return Frama_C_unsigned_int_interval(low, high);
}

static inline uint64_t any_u64(void)
{
    return Frama_C_unsigned_long_long_interval(0, UINT64_MAX);
}

static inline int64_t any_i64(void)
{
    return Frama_C_long_long_interval(INT64_MIN, INT64_MAX);
}

static inline bool any_bool(void)
{
    return Frama_C_interval(0, 1) != 0;
}

#endif
