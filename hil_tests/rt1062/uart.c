/* LPUART6, the console. TDRE becomes set when the data register is free: a byte leaves it when the shift
 * register is, ten bits of the programmed rate later. Bytes sent at another rate than 115,200 are lost, as a
 * terminal would lose them. Behaviour: reference manual, chapter LPUART, from memory (the model has no FIFO).
 */
#include "hil_tests/rt1062/chip.h"
#include <math.h>

enum { BITS_PER_BYTE = 10 };
static const double baud = 115200.0, baud_tolerance = 0.02;

static double rate_of(rt_chip *chip)
{
    double divider = RT_FIELD(chip->uart.baud, LPUART_BAUD_SBR);
    double samples = RT_FIELD(chip->uart.baud, LPUART_BAUD_OSR) + 1.0;
    return divider == 0 ? 0 : rt_clock_uart_Hz(chip) / samples / divider;
}

static uint64_t byte_instants(rt_chip *chip)
{
    double rate = rate_of(chip);
    if (rate <= 0) return RT_NEVER / 2;
    return rt_mutant_time(chip, RT_TIME_UART_BYTE, (uint64_t)(BITS_PER_BYTE / rate * RT_INSTANTS_PER_s));
}

static void update(rt_chip *chip)
{
    rt_uart *uart = &chip->uart;
    if (!uart->is_full || chip->now < uart->busy_until) return;
    uart->is_full = false;
    uart->busy_until += byte_instants(chip);
}

uint32_t rt_uart_read(rt_chip *chip, uint32_t offset)
{
    rt_uart *uart = &chip->uart;
    update(chip);
    switch (offset) {
    case LPUART_BAUD:
        return uart->baud;
    case LPUART_CTRL:
        return uart->control;
    case LPUART_STAT:
        if (!uart->is_full) {
            rt_answered(chip, BASE_LPUART6 + LPUART_STAT);
            return MASK(LPUART_STAT_TDRE);
        }
        rt_pending(chip, BASE_LPUART6 + LPUART_STAT, "LPUART6_STAT TDRE: %s",
                   rate_of(chip) > 0 ? "a byte is being sent" : "the transmitter has no clock");
        return 0;
    default:
        rt_unmodelled(chip, "LPUART6", offset, false);
        return 0;
    }
}

static void send(rt_chip *chip, uint32_t value)
{
    rt_uart *uart = &chip->uart;
    if ((uart->control & MASK(LPUART_CTRL_TE)) == 0) return;
    if (uart->is_full) {
        rt_find(chip, "LPUART6: a byte is written while the data register is full, and is lost");
        return;
    }
    bool is_right = fabs(rate_of(chip) / baud - 1) < baud_tolerance;
    if (!is_right) rt_find(chip, "LPUART6 sends at %.0f baud; the console expects 115,200", rate_of(chip));
    if (chip->now >= uart->busy_until)
        uart->busy_until = chip->now + byte_instants(chip);
    else
        uart->is_full = true;
    if (is_right && rt_pin_is_routed(chip, RT_PIN_CONSOLE) && uart->text_bytes + 1 < sizeof uart->text)
        uart->text[uart->text_bytes++] = (char)value;
}

void rt_uart_write(rt_chip *chip, uint32_t offset, uint32_t value)
{
    rt_uart *uart = &chip->uart;
    update(chip);
    switch (offset) {
    case LPUART_BAUD:
        uart->baud = value;
        break;
    case LPUART_CTRL:
        uart->control = value;
        break;
    case LPUART_DATA:
        send(chip, value & 0xffu);
        break;
    default:
        rt_unmodelled(chip, "LPUART6", offset, true);
    }
}

/* The text stays: a terminal does not forget it. */
void rt_uart_reset(rt_chip *chip)
{
    chip->uart.baud = 0x0f000004;
    chip->uart.control = 0;
    chip->uart.busy_until = 0;
    chip->uart.is_full = false;
}
