/* The checks follow chapter "System boot" of the reference manual, and the flash those of its data sheet
 * (W25Q64JV), both from memory. */
#include "hil_tests/rt1062/rom.h"
#include <string.h>

enum {
    TAG_FLASH = 0x42464346,
    SEQUENCE_AT = 0x80,
    SIZE_AT = 0x50,
    STROBE_AT = 12,
    DEVICE_AT = 0x44,
    TABLE_AT = 0x1000,
    TAG_TABLE = 0xd1,
    TABLE_BYTES = 32,
    DEVICE_NOR = 1,
};

static uint32_t word(const rt_chip *chip, uint32_t offset)
{
    uint32_t value;
    memcpy(&value, chip->flash + offset, sizeof value);
    return value;
}

/* A step of a sequence: opcode, lines (as a power of two) and operand. */
static uint32_t step(uint32_t code, uint32_t lines, uint32_t operand)
{
    return code << 10 | lines << 8 | operand;
}

/* The flash answers "fast read quad I/O": the command on one line; address, six clocks and data on four. */
static bool reads_flash(const rt_chip *chip)
{
    const uint32_t first = word(chip, SEQUENCE_AT), second = word(chip, SEQUENCE_AT + 4);
    return first == (step(1, 0, 0xeb) | step(2, 2, 24) << 16) && (second & 0xffffu) == step(12, 2, 6) &&
           (second >> 26) == 9 && (second >> 24 & 3u) == 2;
}

static bool is_in_flash(uint32_t address, uint32_t bytes)
{
    return address >= RT_FLASH_BEGIN && address - RT_FLASH_BEGIN <= RT_FLASH_BYTES - bytes &&
           address % 4 == 0;
}

const char *rt_rom_boot(const rt_chip *chip, rt_entry *entry)
{
    if (word(chip, 0) != TAG_FLASH) return "the FlexSPI configuration block has no tag FCFB";
    if (chip->flash[DEVICE_AT] != DEVICE_NOR || word(chip, SIZE_AT) != RT_FLASH_BYTES)
        return "the FlexSPI configuration block does not describe this flash";
    if (chip->flash[STROBE_AT] != 1) return "the flash is to be sampled without its looped-back strobe";
    if (!reads_flash(chip)) return "the read sequence does not read this flash";
    uint32_t header = word(chip, TABLE_AT), at = RT_FLASH_BEGIN + TABLE_AT;
    if ((header & 0xffu) != TAG_TABLE || (header >> 8 & 0xffffu) != (TABLE_BYTES & 0xffu) << 8)
        return "the image vector table has no valid header";
    if (word(chip, TABLE_AT + 20) != at) return "the image vector table does not state its own address";
    uint32_t data = word(chip, TABLE_AT + 16), vectors = word(chip, TABLE_AT + 4);
    if (!is_in_flash(data, 12) || !is_in_flash(vectors, 8))
        return "the image vector table points out of the flash";
    uint32_t begin = word(chip, data - RT_FLASH_BEGIN), bytes = word(chip, data - RT_FLASH_BEGIN + 4);
    if (begin != RT_FLASH_BEGIN || bytes > RT_FLASH_BYTES) return "the boot data do not lie in the flash";
    entry->stack = word(chip, vectors - RT_FLASH_BEGIN);
    entry->start = word(chip, vectors - RT_FLASH_BEGIN + 4);
    if ((entry->start & 1u) == 0) return "the start address is not one of Thumb code";
    return NULL;
}
