/* The chip on which most tests of the model begin, and short names for the accesses to its registers. */
#ifndef CRN_RT1062_CHIP_ROOM_H
#define CRN_RT1062_CHIP_ROOM_H

#include "hil_tests/rt1062/chip.h"
#include <stdlib.h>

static inline void wr(rt_chip *chip, uint32_t base, uint32_t offset, uint32_t value)
{
    rt_chip_write(chip, base + offset, 4, value);
}

static inline void wr16(rt_chip *chip, uint32_t base, uint32_t offset, uint32_t value)
{
    rt_chip_write(chip, base + offset, 2, value);
}

static inline uint32_t rd(rt_chip *chip, uint32_t base, uint32_t offset)
{
    return rt_chip_read(chip, base + offset, 4);
}

static inline uint32_t rd16(rt_chip *chip, uint32_t base, uint32_t offset)
{
    return rt_chip_read(chip, base + offset, 2);
}

static inline void open_gates(rt_chip *chip)
{
    for (uint32_t gate = CCM_CCGR0; gate <= CCM_CCGR7; gate += 4) wr(chip, BASE_CCM, gate, 0xffffffffu);
}

/* A chip after its start, whose clock gates are as the ROM leaves them. */
static inline rt_chip *started_chip(void)
{
    rt_chip *chip = rt_chip_create();
    if (chip != NULL) rt_chip_pass_us(chip, 2000);
    return chip;
}

/* For CMocka: a chip with all clock gates open, and the peripherals' clock at 99 MHz (the ROM's 396 MHz / 4).
 */
static inline int open_chip(void **state)
{
    rt_chip *chip = started_chip();
    if (chip == NULL) return -1;
    open_gates(chip);
    *state = chip;
    return 0;
}

static inline int close_chip(void **state)
{
    rt_chip_destroy(*state);
    return 0;
}

#endif
