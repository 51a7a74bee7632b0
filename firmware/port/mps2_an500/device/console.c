/* This file writes text to UART 0, for people and for log files: a banner at power-up and a line for every
 * exception. Each write waits for the UART, so the console's functions are never called while ticks run. */
#include "firmware/port/console_digits.h"
#include "firmware/port/mps2_an500/device/board.h"
#include "firmware/port/mps2_an500/device/device.h"

enum { WAIT_MAX = 100000 }; /* a blocked UART costs a line, not the device */

void console_start(void)
{
    board_uart0->divider = BOARD_UART_DIVIDER_MIN;
    board_uart0->control = BOARD_UART_TRANSMIT_ON;
}

static void put(char letter)
{
    for (int i = 0; i < WAIT_MAX && (board_uart0->state & BOARD_UART_TRANSMIT_FULL) != 0; i++) {
    }
    board_uart0->data = (uint8_t)letter;
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

void console_hex(const char *name, uint64_t value, int digits)
{
    console_text(name);
    for (int i = digits - 1; i >= 0; i--) put("0123456789abcdef"[(value >> (4 * i)) & 15]);
}
