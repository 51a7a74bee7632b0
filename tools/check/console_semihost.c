/* Implements the text output of a check program that runs without an operating system. */
#include "firmware/port/mps2_an500/semihost.h"
#include "tools/check/console.h"

void console_write(const char *text)
{
    semihost_write(text);
}
