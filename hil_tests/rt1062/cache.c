/* The line that was not used for longest leaves its set. The Cortex-M7's own choice is not documented; for
 * the accesses of a tick, which run along the vessels, the difference is small. */
#include "hil_tests/rt1062/cache.h"
#include <string.h>

void rt_cache_clear(rt_cache *cache)
{
    memset(cache->tags, 0, sizeof cache->tags);
    memset(cache->are_changed, 0, sizeof cache->are_changed);
    for (uint32_t set = 0; set < RT_CACHE_SETS; set++)
        for (uint32_t way = 0; way < RT_CACHE_WAYS; way++) cache->ages[set][way] = (uint8_t)way;
}

static void use(rt_cache *cache, uint32_t set, uint32_t way)
{
    uint8_t age = cache->ages[set][way];
    for (uint32_t i = 0; i < RT_CACHE_WAYS; i++)
        if (cache->ages[set][i] < age) cache->ages[set][i]++;
    cache->ages[set][way] = 0;
}

static uint32_t oldest_of(const rt_cache *cache, uint32_t set)
{
    uint32_t oldest = 0;
    for (uint32_t way = 1; way < RT_CACHE_WAYS; way++)
        if (cache->ages[set][way] > cache->ages[set][oldest]) oldest = way;
    return oldest;
}

static void pass(rt_cache *cache, rt_chip *chip, uint64_t instants)
{
    cache->instants += instants;
    chip->now += instants;
    chip->core.cycles += instants / chip->clocks.instants_per_cycle;
}

static uint64_t line_instants(rt_chip *chip, uint32_t address)
{
    if (address >= RT_PSRAM_BEGIN) return rt_flexspi_line_instants(chip);
    return rt_mutant_time(chip, RT_TIME_NEAR_LINE, RT_CACHE_NEAR_CYCLES * chip->clocks.instants_per_cycle);
}

void rt_cache_access(rt_cache *cache, rt_chip *chip, uint32_t address, bool is_write)
{
    uint32_t line = address / RT_CACHE_LINE_BYTES, set = line % RT_CACHE_SETS;
    for (uint32_t way = 0; way < RT_CACHE_WAYS; way++) {
        if (cache->tags[set][way] != line + 1) continue;
        cache->hits++;
        cache->are_changed[set][way] |= is_write;
        use(cache, set, way);
        return;
    }
    uint32_t way = oldest_of(cache, set);
    if (address < RT_PSRAM_BEGIN) {
        cache->near_misses++;
    } else {
        cache->misses++;
    }
    if (cache->are_changed[set][way]) {
        cache->writes++;
        pass(cache, chip, line_instants(chip, (cache->tags[set][way] - 1) * RT_CACHE_LINE_BYTES));
    }
    pass(cache, chip, line_instants(chip, address));
    cache->tags[set][way] = line + 1;
    cache->are_changed[set][way] = is_write;
    use(cache, set, way);
}
