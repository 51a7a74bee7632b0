/* This port has never run on hardware. Before the code in the processor's ROM starts the firmware image, it
 * reads the data of this file from the flash. The data in this file say how to read the flash (FlexSPI
 * configuration block, at 0), where the image is (image vector table, at 0x1000), and how long the image is
 * (structure "boot data").
 *
 * The layout of these data is that of the i.MX RT1060 reference manual, chapter 9 (system boot), tables
 * "FlexSPI NOR configuration block" and "image vector table". The read command and its dummy cycles are those
 * of the flash's data sheet (W25Q64JV, fast read quad I/O, 0xeb). */
#include "firmware/port/imxrt1062/board.h"

struct start_entry; /* start.c */
extern const uint32_t image_flash_begin[], image_flash_bytes[];
extern const struct start_entry start_vectors;

/* Makes one step of a FlexSPI sequence, which is half of a word: the opcode, the number of lines (0: one, 2:
 * four), and the operand. */
#define STEP(opcode, lines, operand) (((opcode) << 10 | (lines) << 8 | (operand)) & 0xffffu)
#define STEPS(first, second) (STEP first | STEP second << 16)
#define COMMAND 1u
#define ADDRESS 2u
#define DUMMY 12u
#define READ 9u

typedef struct boot_flash { /* 512 bytes */
    uint32_t tag, version, reserved0;
    uint8_t sample_clock, hold_time, setup_time, column_width; /* 1: sample with the looped-back strobe */
    uint8_t mode_enable[32], mode_rest[16];
    uint32_t controller_options;
    uint8_t device, lines, clock, has_own_sequences; /* 1: NOR; 4; 3: 60 MHz */
    uint32_t reserved1[2];
    uint32_t sizes[4]; /* A1, A2, B1, B2, bytes */
    uint32_t reserved2[8];
    uint32_t sequences[64]; /* 16 sequences of 4 words; the first one reads */
    uint32_t reserved3[16];
    uint32_t page_bytes, sector_bytes;
    uint32_t reserved4[14];
} boot_flash;
_Static_assert(offsetof(boot_flash, controller_options) == 0x40 && offsetof(boot_flash, sizes) == 0x50 &&
                   offsetof(boot_flash, sequences) == 0x80 && offsetof(boot_flash, page_bytes) == 0x1c0 &&
                   sizeof(boot_flash) == 0x200,
               "the ROM's layout");

__attribute__((section(".boot_flash"), used)) static const boot_flash flash = {
    .tag = 0x42464346,     /* FCFB */
    .version = 0x56010000, /* V 1.0.0 */
    .sample_clock = 1,
    .hold_time = 3,
    .setup_time = 3,
    .device = 1,
    .lines = 4,
    .clock = 3,
    .sizes = {8u << 20},
    .sequences = {STEPS((COMMAND, 0u, 0xebu), (ADDRESS, 2u, 24u)), STEPS((DUMMY, 2u, 6u), (READ, 2u, 4u))},
    .page_bytes = 256,
    .sector_bytes = 4096,
};

__attribute__((section(".boot_data"), used)) static const struct boot_data {
    const uint32_t *begin, *bytes;
    uint32_t is_plugin;
} data = {image_flash_begin, image_flash_bytes, 0};

__attribute__((section(".boot_table"), used)) static const struct boot_table {
    uint32_t header; /* tag 0xd1, 32 bytes, version 0x40 */
    const struct start_entry *entry;
    uint32_t reserved0;
    const uint32_t *device_configuration;
    const struct boot_data *data;
    const struct boot_table *self;
    const uint32_t *signature;
    uint32_t reserved1;
} table = {.header = 0x402000d1, .entry = &start_vectors, .data = &data, .self = &table};
