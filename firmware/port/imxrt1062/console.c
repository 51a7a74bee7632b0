/* This port has never run on hardware. This file writes text on LPUART6 (115,200 baud, pin 1), for people and
 * logs: a banner at power-up and a line for every exception. Each write waits for the UART, so the console's
 * functions are never called while ticks run. */
#include "firmware/port/console_digits.h"
#include "firmware/port/imxrt1062/board.h"
#include "firmware/port/imxrt1062/imxrt1062_registers.h"

enum { SAMPLES_PER_BIT = 16, DIVIDER = BOARD_CRYSTAL_HZ / SAMPLES_PER_BIT / 115200, WAIT_MAX = 100000 };

void console_start(void)
{
    R32(BASE_LPUART6, LPUART_BAUD) =
        BITS(LPUART_BAUD_OSR, SAMPLES_PER_BIT - 1) | BITS(LPUART_BAUD_SBR, DIVIDER);
    R32(BASE_LPUART6, LPUART_CTRL) = MASK(LPUART_CTRL_TE);
}

static void put(char letter)
{
    for (int i = 0; i < WAIT_MAX; i++) {
        if (R32(BASE_LPUART6, LPUART_STAT) & MASK(LPUART_STAT_TDRE)) break;
    }
    R32(BASE_LPUART6, LPUART_DATA) = (uint8_t)letter;
}

void console_text(const char *text)
{
    while (*text != '\0') put(*text++);
}

void console_number(const char *name, uint32_t value)
{
    char text[CONSOLE_DIGITS_BYTES];
    console_text(name);
    console_text(console_digits(text, value));
}

void console_hex(const char *name, uint32_t value)
{
    console_text(name);
    for (int i = 7; i >= 0; i--) put("0123456789abcdef"[value >> (4 * i) & 15u]);
}
