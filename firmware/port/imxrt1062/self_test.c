/* This port has never run on hardware. The self-test of memories and image before anything else, while all
 * pins are still inputs and nothing can have power: docs/safety.md, "Self-test". It runs from the code
 * memory, on the start-up's stack in the OCRAM. */
#include "firmware/port/imxrt1062/board.h"
#include "shared/wire/wire_frame.h"

extern const uint8_t image_flash_begin[], boot_end[], code_begin[], code_end[], data_begin[], data_end[];
extern uint32_t stack_top[], dma_begin[], dma_end[];

/* The CRC-32 of boot header, start-up, code and data; firmware/images/stamp_image.py writes it into the
 * image.
 */
__attribute__((section(".image_check"), used)) static const uint32_t image_crc32 = 0;

enum march { MARCH_UP, MARCH_DOWN };

/* One element of the march: reads every word, which must be `expected`, and then writes its complement.
 * Returns the address of the first wrong word, or 0. */
static uint32_t march(volatile uint32_t *begin, const uint32_t *end, enum march direction, uint32_t expected)
{
    const size_t words = (size_t)(end - (const uint32_t *)begin);
    for (size_t i = 0; i < words; i++) {
        volatile uint32_t *word = begin + (direction == MARCH_UP ? i : words - 1 - i);
        if (*word != expected) return (uint32_t)(uintptr_t)word;
        *word = ~expected;
    }
    return 0;
}

/* March C- on words: every bit takes both values in both directions, so that stuck bits, addresses that meet
 * in one word, and words that disturb each other are found. */
static uint32_t march_all(volatile uint32_t *begin, const uint32_t *end)
{
    for (volatile uint32_t *word = begin; word < end; word++) *word = 0;
    uint32_t bad = march(begin, end, MARCH_UP, 0);
    if (bad == 0) bad = march(begin, end, MARCH_UP, UINT32_MAX);
    if (bad == 0) bad = march(begin, end, MARCH_DOWN, 0);
    if (bad == 0) bad = march(begin, end, MARCH_DOWN, UINT32_MAX);
    for (volatile uint32_t *word = begin; bad == 0 && word < end; word++) {
        if (*word != 0) bad = (uint32_t)(uintptr_t)word;
    }
    return bad;
}

/* Requirement: SR-25 */
uint32_t self_test_memory(void)
{
    const uint32_t bad = march_all((volatile uint32_t *)(uintptr_t)data_begin, stack_top);
    return bad != 0 ? bad : march_all(dma_begin, dma_end);
}

/* Code and data are read from where they were copied to, so the check covers the flash, the copying and the
 * words in which they lie now. */
/* Requirement: SR-24 */
uint32_t self_test_image(void)
{
    uint32_t crc = crn_wire_crc32(0, image_flash_begin, (size_t)(boot_end - image_flash_begin));
    crc = crn_wire_crc32(crc, code_begin, (size_t)(code_end - code_begin));
    crc = crn_wire_crc32(crc, data_begin, (size_t)(data_end - data_begin));
    return crc ^ *(const volatile uint32_t *)&image_crc32;
}

void self_test_stop(const char *what, uint32_t value)
{
    (void)clocks_start();
    pins_start();
    console_start();
    rig_outputs_off();
    console_hex(what, value);
    console_text("; power stays off, waiting for the watchdog's reset\n");
    for (;;) {
    }
}
