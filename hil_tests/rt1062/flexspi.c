/* FlexSPI2, the controller of the PSRAM: a look-up table of sequences (each eight steps of half a word),
 * commands by registers (IPCMD), and the mapped memory at 0x70000000, which the processor reads and writes by
 * two sequences.
 *
 * A command ends only if the controller is on, its clock runs, and its pins are connected. Data that come
 * back are right only if they are sampled with the looped-back strobe (RXCLKSRC 1, pin DQS with its input
 * path on), because the internal loop serves up to 60 MHz. Behaviour: reference manual, chapter FlexSPI, from
 * memory. */
#include "hil_tests/rt1062/chip.h"
#include <string.h>

enum {
    STEPS = 8,
    STOP = 0,
    COMMAND = 1,
    ADDRESS = 2,
    WRITE = 8,
    READ = 9,
    DUMMY = 12,
    STROBE_INTERNAL = 0,
    STROBE_LOOPED_BACK = 1,
    RESET_us = 2,
    LINE_BYTES = 32,
    SEQUENCE_WORDS = 4,
    SIZE_RESET_kB = 0x10000,
};
#define LUT_KEY 0x5af05af0u
static const double internal_strobe_max_Hz = 60e6;

static bool is_on(const rt_flexspi *spi)
{
    return (spi->mcr0 & MASK(FLEXSPI_MCR0_MDIS)) == 0;
}

static bool has_pins(const rt_chip *chip)
{
    for (rt_pin pin = RT_PIN_MEMORY0; pin < RT_PINS; pin++)
        if (!rt_pin_is_routed(chip, pin)) return false;
    return true;
}

/* Clocks of a step that moves `bits` on `lines`. */
static double clocks_of(uint32_t bits, uint32_t lines)
{
    return (double)bits / lines;
}

/* Reads a sequence of the look-up table. Returns its clocks without the data, or a negative number if the
 * sequence is not one that this model knows. */
static double decode(const rt_flexspi *spi, uint32_t sequence, rt_spi *out)
{
    double clocks = (spi->timing & 31u) + (spi->timing >> 5 & 31u); /* select line before and after */
    for (uint32_t i = 0; i < STEPS; i++) {
        uint32_t step = spi->lut[sequence * SEQUENCE_WORDS + i / 2] >> (i % 2 * 16) & 0xffffu;
        uint32_t code = step >> 10, lines = 1u << (step >> 8 & 3u), operand = step & 0xffu;
        switch (code) {
        case STOP:
            return clocks;
        case COMMAND:
            out->command = operand, out->command_lines = lines;
            clocks += clocks_of(8, lines);
            break;
        case ADDRESS:
            out->address_bits = operand, out->address_lines = lines, out->has_address = true;
            clocks += clocks_of(operand, lines);
            break;
        case DUMMY:
            out->dummy_clocks += operand;
            clocks += operand;
            break;
        case READ:
        case WRITE:
            out->data_lines = lines;
            (code == READ ? &out->reads : &out->writes)[0] = true;
            break;
        default:
            return -1;
        }
    }
    return clocks;
}

static bool samples_rightly(rt_chip *chip, double clock)
{
    uint32_t strobe = RT_FIELD(chip->flexspi.mcr0, FLEXSPI_MCR0_RXCLKSRC);
    if (strobe == STROBE_LOOPED_BACK) return (chip->pins.iomuxc[0x70 / 4] & 1u << 4) != 0;
    return strobe == STROBE_INTERNAL && clock <= internal_strobe_max_Hz;
}

/* Runs a sequence; false: nothing or a wrong thing comes back. */
static bool run(rt_chip *chip, uint32_t sequence, uint32_t address, uint32_t bytes, uint8_t *data,
                uint64_t *time)
{
    rt_spi spi = {.address = address, .clock_Hz = rt_clock_flexspi2_Hz(chip)};
    double clocks = decode(&chip->flexspi, sequence, &spi);
    *time = RT_NEVER;
    if (clocks < 0 || spi.clock_Hz <= 0 || !has_pins(chip)) return false;
    spi.data_bytes = spi.reads || spi.writes ? bytes : 0;
    if (spi.data_bytes > 0) clocks += clocks_of(8 * bytes, spi.data_lines);
    *time = (uint64_t)(clocks / spi.clock_Hz * RT_INSTANTS_PER_s);
    bool is_good = rt_psram_transfer(chip, &spi, data);
    if (spi.reads && !samples_rightly(chip, spi.clock_Hz)) {
        memset(data, 0x55, bytes);
        return false;
    }
    return is_good;
}

/* --- the mapped memory --- */
bool rt_flexspi_access(rt_chip *chip, uint32_t address, unsigned bytes, bool is_write, uint32_t *value)
{
    rt_flexspi *spi = &chip->flexspi;
    uint32_t offset = address - RT_PSRAM_BEGIN;
    uint8_t data[4] = {0};
    if (!is_on(spi) || !rt_gate_is_open(chip, 7, 1)) {
        rt_find(chip, "0x%08x: the PSRAM is accessed while FlexSPI2 is off", address);
        return false;
    }
    if (offset / 1024 >= spi->size_kB) {
        rt_find(chip, "0x%08x is beyond the size in FLSHA1CR0", address);
        return false;
    }
    uint32_t sequence = is_write ? RT_FIELD(spi->sequences, FLEXSPI_FLSHCR2_0_AWRSEQID)
                                 : RT_FIELD(spi->sequences, FLEXSPI_FLSHCR2_0_ARDSEQID);
    if (is_write) memcpy(data, value, bytes);
    bool is_good = run(chip, sequence, offset, bytes, data, &spi->access_instants);
    if (spi->access_instants == RT_NEVER) {
        rt_find(chip, "0x%08x: FlexSPI2 has no clock, no pins or no sequence for the PSRAM", address);
        spi->access_instants = 0;
        return false;
    }
    if (!is_good) spi->intr |= MASK(FLEXSPI_INTR_AHBCMDERR);
    if (!is_write) {
        *value = 0;
        memcpy(value, data, bytes);
    }
    return true;
}

bool rt_flexspi_is_sound(rt_chip *chip)
{
    uint8_t probe[4], kept[4];
    uint64_t time;
    rt_flexspi *spi = &chip->flexspi;
    memcpy(kept, chip->psram.memory, sizeof kept);
    if (!is_on(spi) || !rt_gate_is_open(chip, 7, 1) || spi->size_kB < RT_PSRAM_BYTES / 1024) return false;
    bool reads =
        run(chip, RT_FIELD(spi->sequences, FLEXSPI_FLSHCR2_0_ARDSEQID), 0, sizeof probe, probe, &time) &&
        memcmp(probe, kept, sizeof kept) == 0;
    return reads &&
           run(chip, RT_FIELD(spi->sequences, FLEXSPI_FLSHCR2_0_AWRSEQID), 0, sizeof kept, kept, &time);
}

uint64_t rt_flexspi_line_instants(rt_chip *chip)
{
    uint8_t line[LINE_BYTES];
    uint64_t time;
    uint32_t sequence = RT_FIELD(chip->flexspi.sequences, FLEXSPI_FLSHCR2_0_ARDSEQID);
    return run(chip, sequence, 0, sizeof line, line, &time) ? rt_mutant_time(chip, RT_TIME_FLEXSPI_LINE, time)
                                                            : RT_NEVER;
}

/* --- commands by registers --- */
static const char *why_no_command(rt_chip *chip)
{
    if (!is_on(&chip->flexspi)) return "the controller is off (MDIS)";
    if (rt_clock_flexspi2_Hz(chip) <= 0) return "its serial clock does not run";
    if (!has_pins(chip)) return "a pin of the PSRAM is not connected";
    return "the sequence is none that is known";
}

static void start_command(rt_chip *chip)
{
    rt_flexspi *spi = &chip->flexspi;
    uint8_t data[LINE_BYTES] = {0};
    uint64_t time = RT_NEVER;
    if (is_on(spi)) run(chip, RT_FIELD(spi->ipcr1, FLEXSPI_IPCR1_ISEQID), spi->ipcr0, 0, data, &time);
    time = rt_mutant_time(chip, RT_TIME_FLEXSPI_COMMAND, time);
    spi->command_until = time == RT_NEVER ? RT_NEVER : chip->now + time;
}

static uint32_t read_intr(rt_chip *chip)
{
    rt_flexspi *spi = &chip->flexspi;
    if (spi->command_until != 0 && chip->now >= spi->command_until) {
        spi->intr |= MASK(FLEXSPI_INTR_IPCMDDONE);
        spi->command_until = 0;
    }
    if (spi->intr & MASK(FLEXSPI_INTR_IPCMDDONE)) {
        rt_answered(chip, BASE_FLEXSPI2 + FLEXSPI_INTR);
    } else {
        rt_pending(chip, BASE_FLEXSPI2 + FLEXSPI_INTR, "FLEXSPI2_INTR IPCMDDONE: %s",
                   spi->command_until == RT_NEVER ? why_no_command(chip)
                   : spi->command_until == 0      ? "no command was begun"
                                                  : "the command takes its time");
    }
    return spi->intr;
}

static uint32_t read_mcr0(rt_chip *chip)
{
    rt_flexspi *spi = &chip->flexspi;
    if (spi->reset_until == 0) return spi->mcr0;
    bool has_clock = rt_clock_flexspi2_Hz(chip) > 0;
    if (has_clock && is_on(spi) && chip->now >= spi->reset_until) {
        spi->reset_until = 0;
        rt_answered(chip, BASE_FLEXSPI2 + FLEXSPI_MCR0);
        return spi->mcr0;
    }
    rt_pending(chip, BASE_FLEXSPI2 + FLEXSPI_MCR0, "FLEXSPI2_MCR0 SWRESET: %s",
               !is_on(spi)  ? "the controller is off (MDIS)"
               : !has_clock ? "its serial clock does not run"
                            : "the reset takes its time");
    return spi->mcr0 | MASK(FLEXSPI_MCR0_SWRESET);
}

static uint32_t read_status(rt_chip *chip)
{
    const rt_flexspi *spi = &chip->flexspi;
    uint32_t at = BASE_FLEXSPI2 + FLEXSPI_STS0;
    if (is_on(spi) && spi->command_until == 0) {
        rt_answered(chip, at);
        return MASK(FLEXSPI_STS0_SEQIDLE) | MASK(FLEXSPI_STS0_ARBIDLE);
    }
    rt_pending(chip, at, "FLEXSPI2_STS0: %s", is_on(spi) ? "a command runs" : "the controller is off (MDIS)");
    return 0;
}

uint32_t rt_flexspi_read(rt_chip *chip, uint32_t offset)
{
    const rt_flexspi *spi = &chip->flexspi;
    switch (offset) {
    case FLEXSPI_MCR0:
        return read_mcr0(chip);
    case FLEXSPI_INTR:
        return read_intr(chip);
    case FLEXSPI_STS0:
        return read_status(chip);
    case FLEXSPI_AHBCR:
        return spi->ahbcr;
    case FLEXSPI_FLSHA1CR0:
        return spi->size_kB;
    case FLEXSPI_FLSHCR1_0:
        return spi->timing;
    case FLEXSPI_FLSHCR2_0:
        return spi->sequences;
    default:
        rt_unmodelled(chip, "FLEXSPI2", offset, false);
        return 0;
    }
}

static void write_lut(rt_chip *chip, uint32_t index, uint32_t value)
{
    if (!chip->flexspi.is_unlocked)
        rt_find(chip, "FLEXSPI2 LUT word %u is written while the table is locked, and is lost", index);
    else
        chip->flexspi.lut[index] = value;
}

static void set_while_off(rt_chip *chip, uint32_t *word, uint32_t value, const char *name)
{
    if (is_on(&chip->flexspi))
        rt_find(chip, "FLEXSPI2_%s is written while the controller is on (MDIS 0)", name);
    *word = value;
}

void rt_flexspi_write(rt_chip *chip, uint32_t offset, uint32_t value)
{
    rt_flexspi *spi = &chip->flexspi;
    chip->is_map_changed = true;
    if (offset >= FLEXSPI_LUT_0 && offset < FLEXSPI_LUT_0 + 4 * RT_LUT_WORDS) {
        write_lut(chip, (offset - FLEXSPI_LUT_0) / 4, value);
        return;
    }
    switch (offset) {
    case FLEXSPI_MCR0:
        if (value & MASK(FLEXSPI_MCR0_SWRESET))
            spi->reset_until =
                chip->now + rt_mutant_time(chip, RT_TIME_FLEXSPI_RESET, RESET_us * RT_INSTANTS_PER_us);
        spi->mcr0 = value & ~MASK(FLEXSPI_MCR0_SWRESET);
        break;
    case FLEXSPI_AHBCR:
        spi->ahbcr = value;
        break;
    case FLEXSPI_INTR:
        spi->intr &= ~value;
        break;
    case FLEXSPI_LUTKEY:
        spi->lutkey = value;
        break;
    case FLEXSPI_LUTCR: /* acts only directly after the key */
        if (spi->lutkey == LUT_KEY) spi->is_unlocked = (value & MASK(FLEXSPI_LUTCR_UNLOCK)) != 0;
        spi->lutkey = 0;
        break;
    case FLEXSPI_FLSHA1CR0:
        set_while_off(chip, &spi->size_kB, value, "FLSHA1CR0");
        break;
    case FLEXSPI_FLSHCR1_0:
        set_while_off(chip, &spi->timing, value, "FLSHCR1");
        break;
    case FLEXSPI_FLSHCR2_0:
        set_while_off(chip, &spi->sequences, value, "FLSHCR2");
        break;
    case FLEXSPI_IPCR0:
        spi->ipcr0 = value;
        break;
    case FLEXSPI_IPCR1:
        spi->ipcr1 = value;
        break;
    case FLEXSPI_IPCMD:
        if (value & MASK(FLEXSPI_IPCMD_TRG)) start_command(chip);
        break;
    default:
        rt_unmodelled(chip, "FLEXSPI2", offset, true);
    }
}

/* The PSRAM keeps its mode and contents over a reset of the processor. */
void rt_flexspi_reset(rt_chip *chip)
{
    chip->flexspi =
        (rt_flexspi){.mcr0 = MASK(FLEXSPI_MCR0_MDIS), .size_kB = SIZE_RESET_kB, .timing = 3 | 3 << 5};
    chip->is_map_changed = true;
}
