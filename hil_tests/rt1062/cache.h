/* The time that the data cache costs. The cache holds no data in this model (unicorn reads the memory
 * itself), only which lines it has: 32 kB, 4 ways, lines of 32 bytes, as the Cortex-M7 of the RT1062. The
 * PSRAM and near memory (the cached part of the OCRAM) are cached while the device runs. A miss takes a line
 * from FlexSPI2 or from the OCRAM, and a changed line that has to leave is written first. */
#ifndef CRN_RT1062_CACHE_H
#define CRN_RT1062_CACHE_H

#include "hil_tests/rt1062/chip.h"

enum {
    RT_CACHE_SETS = 256,
    RT_CACHE_WAYS = 4,
    RT_CACHE_LINE_BYTES = 32,
    RT_CACHE_NEAR_CYCLES = 44, /* a line of the OCRAM: 11 clocks of 150 MHz, assumed */
};

typedef struct rt_cache {
    uint32_t tags[RT_CACHE_SETS][RT_CACHE_WAYS]; /* address of the line + 1; 0: empty */
    uint8_t ages[RT_CACHE_SETS][RT_CACHE_WAYS];  /* 0: used last */
    bool are_changed[RT_CACHE_SETS][RT_CACHE_WAYS];
    uint64_t hits, misses, writes, instants; /* misses: in the PSRAM; instants: spent on lines */
    uint64_t near_misses;
} rt_cache;

void rt_cache_clear(rt_cache *cache);
/* An access of the processor; lets the time pass that it takes. */
void rt_cache_access(rt_cache *cache, rt_chip *chip, uint32_t address, bool is_write);

#endif
