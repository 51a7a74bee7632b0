/* This header converts numbers to decimal digits for a board's console. It is freestanding. */
#ifndef CRN_PORT_CONSOLE_DIGITS_H
#define CRN_PORT_CONSOLE_DIGITS_H

#include <stdint.h>

enum { CONSOLE_DIGITS_BYTES = 11 }; /* the digits of 2^32 - 1 and the terminator */

/* Writes the decimal digits into `text` and returns a pointer to the first digit. */
static inline const char *console_digits(char text[CONSOLE_DIGITS_BYTES], uint32_t value)
{
    int at = CONSOLE_DIGITS_BYTES - 1;
    text[at] = '\0';
    do {
        text[--at] = (char)('0' + value % 10);
        value /= 10;
    } while (value != 0);
    return &text[at];
}

#endif
