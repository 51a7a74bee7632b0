/* This port has never run on hardware. Caches and protection. Memory that other bus masters also write is
 * never cached: the registers, and the part of the OCRAM with the USB controller's lists and buffers. */
#include "firmware/port/imxrt1062/board.h"
#include "firmware/port/imxrt1062/cortex_m7.h"

extern uint32_t stack_guard[];

enum { /* fields of CORE_MPU_RASR: type (TEX, S, C, B), access, size as 2^(n + 1) bytes */
       TYPE_DEVICE = 1 << 16,
       TYPE_UNCACHED = 1 << 19,
       TYPE_WRITE_THROUGH = 1 << 17,
       TYPE_WRITE_BACK = 1 << 19 | 1 << 17 | 1 << 16,
       ACCESS_NONE = 0,
       ACCESS_ALL = 3 << 24,
       ACCESS_READ = 7 << 24,
       NEVER_CODE = 1 << 28,
       SIZE_32_B = 4,
       SIZE_8_MB = 22,
       SIZE_512_kB = 18,
       SIZE_512_MB = 28,
       SIZE_4_GB = 31,
       LINE_SHIFT = 5,
       /* Near memory is the OCRAM from 128 kB on (image.ld): of the eight equal parts of a region, all but
        * the first two. */
       WITHOUT_FIRST_TWO = 3 << 8,
};

typedef struct region {
    uintptr_t begin;
    uint32_t attributes, size;
} region;

/* Where two memory regions overlap, the one later in the list applies. */
static void protect(void)
{
    const region regions[] = {
        {0x00000000u, TYPE_DEVICE | ACCESS_NONE | NEVER_CODE, SIZE_4_GB},
        {0x00000000u, TYPE_UNCACHED | ACCESS_READ, SIZE_512_kB},             /* code memory */
        {0x20000000u, TYPE_UNCACHED | ACCESS_ALL | NEVER_CODE, SIZE_512_kB}, /* data memory */
        {0x20200000u, TYPE_UNCACHED | ACCESS_ALL | NEVER_CODE, SIZE_512_kB}, /* OCRAM: USB */
        {0x20200000u, TYPE_WRITE_BACK | ACCESS_ALL | NEVER_CODE | WITHOUT_FIRST_TWO, SIZE_512_kB},
        {0x40000000u, TYPE_DEVICE | ACCESS_ALL | NEVER_CODE, SIZE_512_MB},   /* registers */
        {0x60000000u, TYPE_WRITE_THROUGH | ACCESS_READ, SIZE_8_MB},          /* flash */
        {0x70000000u, TYPE_WRITE_BACK | ACCESS_ALL | NEVER_CODE, SIZE_8_MB}, /* PSRAM: scenes */
        {(uintptr_t)stack_guard, TYPE_UNCACHED | ACCESS_NONE | NEVER_CODE, SIZE_32_B},
    };
    for (uint32_t i = 0; i < sizeof regions / sizeof regions[0]; i++) {
        CORE_MPU_RBAR = (uint32_t)regions[i].begin | CORE_MPU_REGION_VALID | i;
        CORE_MPU_RASR = regions[i].attributes | regions[i].size << 1 | 1u;
    }
    CORE_SHCSR |= CORE_SHCSR_FAULTS;
    core_barrier();
    CORE_MPU_CTRL = CORE_MPU_ON;
    core_barrier();
}

/* After a reset the contents of the caches are undefined, so the code invalidates the caches before it turns
 * them on. */
static void start_caches(void)
{
    CORE_ICIALLU = 0;
    CORE_CSSELR = 0;
    core_barrier();
    uint32_t geometry = CORE_CCSIDR;
    uint32_t sets = (geometry >> 13 & 0x7fffu) + 1u, ways = (geometry >> 3 & 0x3ffu) + 1u;
    for (uint32_t set = 0; set < sets; set++) {
        for (uint32_t way = 0; way < ways; way++) CORE_DCISW = way << 30 | set << LINE_SHIFT;
    }
    core_barrier();
    CORE_CCR |= CORE_CCR_INSTRUCTION_CACHE | CORE_CCR_DATA_CACHE;
    core_barrier();
}

void memory_map_start(void)
{
    protect();
    start_caches();
}
