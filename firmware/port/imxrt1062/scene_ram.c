/* This port has never run on hardware. This file starts the PSRAM for scenes (8 MB, APS6404L or ESP-PSRAM64H)
 * at 0x70000000, through FlexSPI2 with four lines for commands, addresses and data. The commands to the PSRAM
 * are those of its data sheet. The PSRAM is used only after a test of its address lines. */
#include "firmware/port/imxrt1062/board.h"
#include "firmware/port/imxrt1062/imxrt1062_registers.h"

enum {
    STEP_COMMAND = 1,
    STEP_ADDRESS = 2,
    STEP_WRITE = 8,
    STEP_READ = 9,
    STEP_DUMMY = 12,
    ONE_LINE = 0,
    FOUR_LINES = 2,
    SEQUENCE_WORDS = 4,
    READ_BACK_STROBE = 1,
    CLOCK_PLL2_PFD2 = 0, /* 396 MHz / 5 = 79 MHz */
    CLOCK_DIVIDE_BY_5 = 4,
    SIZE_kB = 8 << 10,
    RAM_BYTES = SIZE_kB << 10,
};
#define RAM_BEGIN 0x70000000u
#define LUT_KEY 0x5af05af0u

enum {
    SEQUENCE_READ,
    SEQUENCE_WRITE,
    SEQUENCE_RESET_ENABLE,
    SEQUENCE_RESET,
    SEQUENCE_FOUR_LINES,
    SEQUENCE_ONE_LINE
};

static uint32_t step(uint32_t opcode, uint32_t lines, uint32_t operand)
{
    return opcode << 10 | lines << 8 | operand;
}

static void set_sequence(uint32_t number, uint32_t first, uint32_t second, uint32_t third, uint32_t fourth)
{
    uint32_t at = FLEXSPI_LUT_0 + number * SEQUENCE_WORDS * FLEXSPI_STRIDE_LUT;
    R32(BASE_FLEXSPI2, at) = first | second << 16;
    R32(BASE_FLEXSPI2, at + FLEXSPI_STRIDE_LUT) = third | fourth << 16;
    R32(BASE_FLEXSPI2, at + 2 * FLEXSPI_STRIDE_LUT) = 0;
    R32(BASE_FLEXSPI2, at + 3 * FLEXSPI_STRIDE_LUT) = 0;
}

static void set_sequences(void)
{
    R32(BASE_FLEXSPI2, FLEXSPI_LUTKEY) = LUT_KEY;
    R32(BASE_FLEXSPI2, FLEXSPI_LUTCR) = MASK(FLEXSPI_LUTCR_UNLOCK);
    set_sequence(SEQUENCE_READ, step(STEP_COMMAND, FOUR_LINES, 0xeb), step(STEP_ADDRESS, FOUR_LINES, 24),
                 step(STEP_DUMMY, FOUR_LINES, 6), step(STEP_READ, FOUR_LINES, 4));
    set_sequence(SEQUENCE_WRITE, step(STEP_COMMAND, FOUR_LINES, 0x38), step(STEP_ADDRESS, FOUR_LINES, 24),
                 step(STEP_WRITE, FOUR_LINES, 4), 0);
    set_sequence(SEQUENCE_RESET_ENABLE, step(STEP_COMMAND, ONE_LINE, 0x66), 0, 0, 0);
    set_sequence(SEQUENCE_RESET, step(STEP_COMMAND, ONE_LINE, 0x99), 0, 0, 0);
    set_sequence(SEQUENCE_FOUR_LINES, step(STEP_COMMAND, ONE_LINE, 0x35), 0, 0, 0);
    set_sequence(SEQUENCE_ONE_LINE, step(STEP_COMMAND, FOUR_LINES, 0xf5), 0, 0, 0);
}

static bool command(uint32_t sequence)
{
    volatile uint32_t *done = &R32(BASE_FLEXSPI2, FLEXSPI_INTR);
    R32(BASE_FLEXSPI2, FLEXSPI_IPCR0) = 0;
    R32(BASE_FLEXSPI2, FLEXSPI_IPCR1) = BITS(FLEXSPI_IPCR1_ISEQID, sequence);
    R32(BASE_FLEXSPI2, FLEXSPI_IPCMD) = MASK(FLEXSPI_IPCMD_TRG);
    bool is_done = board_wait(done, MASK(FLEXSPI_INTR_IPCMDDONE), MASK(FLEXSPI_INTR_IPCMDDONE));
    bool is_good = is_done && (*done & MASK(FLEXSPI_INTR_IPCMDERR)) == 0;
    *done = MASK(FLEXSPI_INTR_IPCMDDONE) | MASK(FLEXSPI_INTR_IPCMDERR);
    return is_good;
}

/* Writes a different word at 0 and at every power of two, which reveals a missing chip or address line. */
static bool test_memory(void)
{
    volatile uint32_t *ram = (volatile uint32_t *)(uintptr_t)RAM_BEGIN;
    for (uint32_t word = RAM_BYTES / 8; word != 0; word >>= 1) ram[word] = ~word * 2654435761u;
    ram[0] = 0xa5c33c5au;
    bool is_good = ram[0] == 0xa5c33c5au;
    for (uint32_t word = RAM_BYTES / 8; word != 0; word >>= 1)
        is_good = is_good && ram[word] == ~word * 2654435761u;
    return is_good;
}

/* The PSRAM is tested before the caches are on, so that every access of the test reaches the chip. */
bool scene_ram_start(void)
{
    volatile uint32_t *control = &R32(BASE_FLEXSPI2, FLEXSPI_MCR0);
    *control |= MASK(FLEXSPI_MCR0_MDIS);
    SET_FIELD(R32(BASE_CCM, CCM_CBCMR), CCM_CBCMR_FLEXSPI2_CLK_SEL, CLOCK_PLL2_PFD2);
    SET_FIELD(R32(BASE_CCM, CCM_CBCMR), CCM_CBCMR_FLEXSPI2_PODF, CLOCK_DIVIDE_BY_5);
    SET_FIELD(*control, FLEXSPI_MCR0_RXCLKSRC, READ_BACK_STROBE);
    *control &= ~MASK(FLEXSPI_MCR0_MDIS);
    *control |= MASK(FLEXSPI_MCR0_SWRESET);
    if (!board_wait(control, MASK(FLEXSPI_MCR0_SWRESET), 0)) return false;

    *control |= MASK(FLEXSPI_MCR0_MDIS);
    R32(BASE_FLEXSPI2, FLEXSPI_AHBCR) =
        MASK(FLEXSPI_AHBCR_READADDROPT) | MASK(FLEXSPI_AHBCR_BUFFERABLEEN) | MASK(FLEXSPI_AHBCR_CACHABLEEN);
    SET_FIELD(R32(BASE_FLEXSPI2, FLEXSPI_FLSHA1CR0), FLEXSPI_FLSHA1CR0_FLSHSZ, SIZE_kB);
    SET_FIELD(R32(BASE_FLEXSPI2, FLEXSPI_FLSHCR1_0), FLEXSPI_FLSHCR1_0_TCSS, 3);
    SET_FIELD(R32(BASE_FLEXSPI2, FLEXSPI_FLSHCR1_0), FLEXSPI_FLSHCR1_0_TCSH, 3);
    R32(BASE_FLEXSPI2, FLEXSPI_FLSHCR2_0) =
        BITS(FLEXSPI_FLSHCR2_0_ARDSEQID, SEQUENCE_READ) | BITS(FLEXSPI_FLSHCR2_0_AWRSEQID, SEQUENCE_WRITE);
    *control &= ~MASK(FLEXSPI_MCR0_MDIS);
    uint32_t idle = MASK(FLEXSPI_STS0_SEQIDLE) | MASK(FLEXSPI_STS0_ARBIDLE);
    if (!board_wait(&R32(BASE_FLEXSPI2, FLEXSPI_STS0), idle, idle)) return false;
    set_sequences();
    /* If only the processor was reset, the PSRAM still expects its commands on four lines. */
    return command(SEQUENCE_ONE_LINE) && command(SEQUENCE_RESET_ENABLE) && command(SEQUENCE_RESET) &&
           command(SEQUENCE_FOUR_LINES) && test_memory();
}
