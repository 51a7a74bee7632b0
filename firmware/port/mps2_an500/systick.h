/* This header reads the processor's 24-bit counter, which counts down at the processor's clock. QEMU with
 * -icount shift=0 gives each instruction 1 ns, and this board's clock is 25 MHz, so one count is exactly 40
 * instructions in QEMU. */
#ifndef CRN_PORT_SYSTICK_H
#define CRN_PORT_SYSTICK_H

#include <stdint.h>

enum { SYSTICK_INSTRUCTIONS_PER_COUNT = 40, SYSTICK_MASK = 0xffffff };

static volatile uint32_t *const systick = (volatile uint32_t *)0xe000e010u; /* control, reload, value */

static inline void systick_start(void)
{
    systick[1] = SYSTICK_MASK;
    systick[2] = 0;
    systick[0] = 5; /* processor clock, no interrupt, on */
}

/* Returns the number of counts since `start`, which came from systick_now(). The returned number of counts is
 * correct if fewer than 2^24 counts have passed since `start`. */
static inline uint32_t systick_now(void)
{
    return systick[2];
}
static inline uint32_t systick_since(uint32_t start)
{
    return (start - systick_now()) & SYSTICK_MASK;
}

#endif
