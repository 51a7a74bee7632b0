/* This port has never run on hardware. This header has the Cortex-M7's own registers, at the addresses that
 * ARM's architecture (ARMv7-M, B3) gives them on every such processor. */
#ifndef CRN_CORTEX_M7_H
#define CRN_CORTEX_M7_H

#include <stdint.h>

#define CORE32(address) (*(volatile uint32_t *)(uintptr_t)(address))

/* System control block */
#define CORE_VTOR CORE32(0xe000ed08u)
#define CORE_CCR CORE32(0xe000ed14u)
#define CORE_SHCSR CORE32(0xe000ed24u)
#define CORE_CFSR CORE32(0xe000ed28u)
enum {
    CORE_CCR_INSTRUCTION_CACHE = 1 << 17,
    CORE_CCR_DATA_CACHE = 1 << 16,
    CORE_CCR_IGNORE_BUS_FAULTS = 1 << 8, /* BFHFNMIGN: while FAULTMASK is set */
    CORE_SHCSR_FAULTS = 7 << 16
};

/* Caches */
#define CORE_CCSIDR CORE32(0xe000ed80u)
#define CORE_CSSELR CORE32(0xe000ed84u)
#define CORE_ICIALLU CORE32(0xe000ef50u)
#define CORE_DCISW CORE32(0xe000ef60u)

/* Memory protection unit */
#define CORE_MPU_CTRL CORE32(0xe000ed94u)
#define CORE_MPU_RBAR CORE32(0xe000ed9cu)
#define CORE_MPU_RASR CORE32(0xe000eda0u)
enum { CORE_MPU_ON = 1, CORE_MPU_REGION_VALID = 1 << 4 };

/* Cycle counter */
#define CORE_DEMCR CORE32(0xe000edfcu)
#define CORE_DWT_LAR CORE32(0xe0001fb0u)
#define CORE_DWT_CTRL CORE32(0xe0001000u)
#define CORE_DWT_CYCCNT CORE32(0xe0001004u)
enum { CORE_DEMCR_TRACE = 1 << 24, CORE_DWT_CYCLES = 1 };
static const uint32_t core_dwt_key = 0xc5acce55u;

/* Interrupt controller: bit n of word n / 32 */
#define CORE_NVIC_ENABLE(number) CORE32(0xe000e100u + 4u * ((number) / 32u))

static inline void core_barrier(void)
{
    __asm__ volatile("dsb\n isb" ::: "memory");
}

/* Makes all earlier writes visible in memory to other bus masters, before any later access. */
static inline void core_data_barrier(void)
{
    __asm__ volatile("dsb" ::: "memory");
}

#endif
