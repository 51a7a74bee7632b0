/* What the boot ROM does with the flash: it reads the FlexSPI configuration block and the image vector table,
 * and jumps to the image. It refuses a flash that the stated read sequence cannot read. */
#ifndef CRN_RT1062_ROM_H
#define CRN_RT1062_ROM_H

#include "hil_tests/rt1062/chip.h"

typedef struct rt_entry {
    uint32_t stack, start;
} rt_entry;

/* Returns NULL and the place where the image starts, or why the ROM refuses the flash's contents. */
const char *rt_rom_boot(const rt_chip *chip, rt_entry *entry);

#endif
