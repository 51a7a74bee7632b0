/* The Cortex-M7's own registers: interrupt controller, system control block, memory protection, caches, cycle
 * counter. Behaviour: ARMv7-M architecture reference manual, B3 and C1, from memory. The caches hold nothing
 * in this model; it checks that they are invalidated before they are turned on, and the engine counts their
 * misses. */
#include "hil_tests/rt1062/chip.h"

enum {
    VTOR = 0x08,
    CCR = 0x14,
    SHCSR = 0x24,
    CFSR = 0x28,
    CCSIDR = 0x80,
    CSSELR = 0x84,
    MPU_CTRL = 0x94,
    MPU_RBAR = 0x9c,
    MPU_RASR = 0xa0,
    DEMCR = 0xfc,
    ICIALLU = 0x250,
    DCISW = 0x260,
    NVIC_ENABLE = 0x100, /* of 0xe000e000 */
    DATA_SETS = 256,     /* 32 kB, 4 ways, lines of 32 bytes */
    DATA_WAYS = 4,
    CODE_SETS = 512, /* 32 kB, 2 ways */
    CODE_WAYS = 2,
    DATA_CACHE = 1 << 16,
    CODE_CACHE = 1 << 17,
    TRACE = 1 << 24,
    DWT_COUNTS = 1,
    RASR_ON = 1,
    NEVER_CODE = 1 << 28,
    MPU_ON = 1,
    MPU_BACKGROUND = 4,
};
#define SCB 0xe000ed00u
#define NVIC 0xe000e000u
#define DWT_CTRL 0xe0001000u
#define DWT_CYCCNT 0xe0001004u
#define DWT_LAR 0xe0001fb0u
#define DWT_KEY 0xc5acce55u

static uint32_t geometry(const rt_core *core)
{
    uint32_t sets = core->csselr & 1u ? CODE_SETS : DATA_SETS,
             ways = core->csselr & 1u ? CODE_WAYS : DATA_WAYS;
    return 0xf0000000u | (sets - 1) << 13 | (ways - 1) << 3 | 1u;
}

static uint32_t read_scb(rt_chip *chip, uint32_t offset)
{
    const rt_core *core = &chip->core;
    switch (offset) {
    case VTOR:
        return core->vtor;
    case CCR:
        return core->ccr;
    case SHCSR:
        return core->shcsr;
    case CFSR:
        return core->cfsr;
    case CCSIDR:
        return geometry(core);
    case CSSELR:
        return core->csselr;
    case MPU_CTRL:
        return core->mpu_control;
    case DEMCR:
        return core->demcr;
    default:
        rt_unmodelled(chip, "SCB", offset, false);
        return 0;
    }
}

uint32_t rt_core_read(rt_chip *chip, uint32_t address)
{
    const rt_core *core = &chip->core;
    if (address >= SCB && address < SCB + 0x300) return read_scb(chip, address - SCB);
    if (address == DWT_CYCCNT) return (uint32_t)(core->cycles - core->count_begin);
    if (address == DWT_CTRL) return core->dwt_control;
    uint32_t word = (address - NVIC - NVIC_ENABLE) / 4;
    if (word < 8) return core->enabled[word];
    rt_unmodelled(chip, "core", address, false);
    return 0;
}

static void write_ccr(rt_chip *chip, uint32_t value)
{
    rt_core *core = &chip->core;
    uint32_t on = value & ~core->ccr;
    if ((on & DATA_CACHE) != 0 && core->lines_invalidated < DATA_SETS * DATA_WAYS)
        rt_find(chip, "the data cache is turned on with %u of 1,024 lines invalidated",
                core->lines_invalidated);
    if ((on & CODE_CACHE) != 0 && !core->are_instructions_invalidated)
        rt_find(chip, "the instruction cache is turned on before it is invalidated");
    core->ccr = value;
    chip->is_map_changed = true;
}

static void write_region(rt_chip *chip, uint32_t offset, uint32_t value)
{
    rt_core *core = &chip->core;
    static const uint32_t valid = 1u << 4;
    if (offset == MPU_RBAR && (value & valid) == 0) {
        rt_find(chip, "MPU_RBAR without VALID: the model has no MPU_RNR");
        return;
    }
    if (offset == MPU_RBAR) {
        core->mpu_region = value & 15u;
        core->begin[core->mpu_region] = value & ~31u;
    } else {
        core->size[core->mpu_region] = value;
    }
    chip->is_map_changed = true;
}

/* Way in bits 30 and 31, set from bit 5 on. */
static void invalidate_line(rt_core *core, uint32_t value)
{
    uint32_t line = (value >> 30) * DATA_SETS + (value >> 5) % DATA_SETS, bit = 1u << line % 32;
    if ((core->invalidated[line / 32] & bit) == 0) core->lines_invalidated++;
    core->invalidated[line / 32] |= bit;
}

static void write_scb(rt_chip *chip, uint32_t offset, uint32_t value)
{
    rt_core *core = &chip->core;
    switch (offset) {
    case VTOR:
        if (value % 1024 != 0) rt_find(chip, "VTOR 0x%08x is not aligned to 1,024 bytes", value);
        core->vtor = value;
        break;
    case CCR:
        write_ccr(chip, value);
        break;
    case SHCSR:
        core->shcsr = value;
        break;
    case CFSR:
        core->cfsr &= ~value;
        break;
    case CSSELR:
        core->csselr = value;
        break;
    case MPU_CTRL:
        core->mpu_control = value;
        chip->is_map_changed = true;
        break;
    case MPU_RBAR:
    case MPU_RASR:
        write_region(chip, offset, value);
        break;
    case DEMCR:
        core->demcr = value;
        break;
    case ICIALLU:
        core->are_instructions_invalidated = true;
        break;
    case DCISW:
        invalidate_line(core, value);
        break;
    default:
        rt_unmodelled(chip, "SCB", offset, true);
    }
}

void rt_core_write(rt_chip *chip, uint32_t address, uint32_t value)
{
    rt_core *core = &chip->core;
    uint32_t word = (address - NVIC - NVIC_ENABLE) / 4;
    if (address >= SCB && address < SCB + 0x300) {
        write_scb(chip, address - SCB, value);
    } else if (address == DWT_LAR) {
        core->is_dwt_unlocked = value == DWT_KEY;
    } else if (address == DWT_CTRL) {
        if ((core->demcr & TRACE) == 0 || !core->is_dwt_unlocked)
            rt_find(chip, "DWT_CTRL is written before DEMCR TRCENA and the key");
        core->dwt_control = value;
    } else if (address == DWT_CYCCNT) {
        core->count_begin = core->cycles - value;
    } else if (word < 8) {
        core->enabled[word] |= value;
    } else {
        rt_unmodelled(chip, "core", address, true);
    }
}

/* --- memory protection --- */
static int region_of(const rt_core *core, uint32_t address)
{
    for (int i = RT_MPU_REGIONS - 1; i >= 0; i--) {
        if ((core->size[i] & RASR_ON) == 0) continue;
        uint32_t log2_bytes = (core->size[i] >> 1 & 31u) + 1u;
        uint32_t mask = log2_bytes >= 32 ? 0 : ~((1u << log2_bytes) - 1u);
        if ((address & mask) != (core->begin[i] & mask)) continue;
        /* each of the eight equal parts can be left out, unless they are smaller than 32 bytes */
        uint32_t part = log2_bytes < 8 ? 0 : (address & ~mask) >> (log2_bytes - 3u);
        if (log2_bytes < 8 || (core->size[i] >> (8 + part) & 1u) == 0) return i;
    }
    return -1;
}

bool rt_mpu_allows(const rt_chip *chip, uint32_t address, rt_access access)
{
    const rt_core *core = &chip->core;
    if ((core->mpu_control & MPU_ON) == 0) return true;
    int region = region_of(core, address);
    if (region < 0) return (core->mpu_control & MPU_BACKGROUND) != 0;
    uint32_t rasr = core->size[region], permission = rasr >> 24 & 7u;
    bool reads = permission != 0, writes = permission == 1 || permission == 2 || permission == 3;
    if (access == RT_ACCESS_CODE) return reads && (rasr & NEVER_CODE) == 0;
    return access == RT_ACCESS_READ ? reads : writes;
}

bool rt_mpu_is_cached(const rt_chip *chip, uint32_t address)
{
    const rt_core *core = &chip->core;
    if ((core->mpu_control & MPU_ON) == 0) return address >= RT_FLASH_BEGIN; /* the default map */
    int region = region_of(core, address);
    uint32_t rasr = region < 0 ? 0 : core->size[region];
    return (rasr >> 17 & 1u) != 0; /* C: write-through or write-back */
}

bool rt_core_has_data_cache(const rt_chip *chip)
{
    return (chip->core.ccr & DATA_CACHE) != 0;
}

void rt_core_reset(rt_chip *chip)
{
    uint64_t cycles = chip->core.cycles;
    chip->core = (rt_core){.cycles = cycles};
    chip->is_map_changed = true;
}
