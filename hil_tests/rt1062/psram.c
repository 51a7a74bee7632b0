/* The PSRAM behind FlexSPI2: APS6404L, 8 MB. It understands a command only on the number of lines that its
 * mode expects (one after power-up, four after 0x35), reads by 0xeb with 24 bits of address and 6 clocks of
 * waiting on four lines, and writes by 0x38. Behaviour: data sheet APS6404L-3SQR, from memory. A command that
 * it does not understand changes nothing, and a read then finds ones. */
#include "hil_tests/rt1062/chip.h"
#include <string.h>

enum {
    READ_FOUR = 0xeb,
    READ_WAIT_clocks = 6,
    WRITE_FOUR = 0x38,
    RESET_ENABLE = 0x66,
    RESET = 0x99,
    ENTER_FOUR = 0x35,
    LEAVE_FOUR = 0xf5,
    ADDRESS_BITS = 24,
    PAGE_BYTES = 1024,
};
static const double clock_max_Hz = 109e6;

static bool is_bare(const rt_spi *spi)
{
    return !spi->has_address && spi->data_bytes == 0;
}

static bool is_data(const rt_spi *spi)
{
    return spi->has_address && spi->address_lines == 4 && spi->data_lines == 4 &&
           spi->address_bits == ADDRESS_BITS;
}

/* A command on other lines than expected is an incomplete one: the select line rises before its last bit. */
static bool run_command(rt_psram *psram, const rt_spi *spi)
{
    bool was_enabled = psram->is_reset_enabled;
    if (spi->command_lines != (psram->has_four_lines ? 4u : 1u)) return true;
    psram->is_reset_enabled = spi->command == RESET_ENABLE;
    if (spi->command == RESET && was_enabled) psram->has_four_lines = false;
    if (spi->command == ENTER_FOUR) psram->has_four_lines = true;
    if (spi->command == LEAVE_FOUR) psram->has_four_lines = false;
    return true;
}

bool rt_psram_transfer(rt_chip *chip, const rt_spi *spi, uint8_t *data)
{
    rt_psram *psram = &chip->psram;
    if (spi->reads) memset(data, 0xff, spi->data_bytes);
    if (!psram->is_fitted || spi->clock_Hz <= 0) return false;
    if (spi->clock_Hz > clock_max_Hz) {
        rt_find(chip, "the PSRAM is clocked at %.1f MHz; at most 109 over whole lines", spi->clock_Hz * 1e-6);
        return false;
    }
    if (is_bare(spi)) return run_command(psram, spi);
    bool understands = psram->has_four_lines && spi->command_lines == 4 && is_data(spi) &&
                       spi->address % PAGE_BYTES + spi->data_bytes <= PAGE_BYTES;
    uint32_t at = spi->address % RT_PSRAM_BYTES;
    if (understands && spi->reads && spi->command == READ_FOUR && spi->dummy_clocks == READ_WAIT_clocks) {
        memcpy(data, psram->memory + at, spi->data_bytes);
        return true;
    }
    if (understands && spi->writes && spi->command == WRITE_FOUR && spi->dummy_clocks == 0) {
        memcpy(psram->memory + at, data, spi->data_bytes);
        return true;
    }
    return false;
}
