/* Implements the text output of a check program that runs under an operating system. */
#include "tools/check/console.h"

#include <stdio.h>

void console_write(const char *text)
{
    fputs(text, stdout);
}
