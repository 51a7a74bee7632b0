/* Decimal digits for a board's console. Freestanding. */
#ifndef CRN_PORT_CONSOLE_DIGITS_H
#define CRN_PORT_CONSOLE_DIGITS_H

#include <stdint.h>

enum { CONSOLE_DIGITS_BYTES = 11 }; /* of 2^32 - 1, and the end */

/* The first digit, in `text`. */
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
