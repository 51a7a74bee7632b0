/* This file contains the code that runs from the reset of a Cortex-M7 to main(). An unexpected exception
 * prints its number and ends the program with exit code 1. */
#include <stddef.h>
#include <stdint.h>

#include "firmware/port/mps2_an500/semihost.h"

extern uint32_t data_start[], data_end[], data_load[], bss_start[], bss_end[], stack_top[];
int main(int argc, char **argv);
void reset(void);

enum { ARGUMENTS_MAX = 16, EXCEPTIONS = 16 };

static void copy_words(uint32_t *to, const uint32_t *to_end, const uint32_t *from)
{
    while (to < to_end) *to++ = *from++;
}

void reset(void)
{
    static char line[256];
    static char *arguments[ARGUMENTS_MAX + 1];
    copy_words(data_start, data_end, data_load);
    for (uint32_t *word = bss_start; word < bss_end; word++) *word = 0;
    int count = semihost_arguments(line, sizeof line, arguments, ARGUMENTS_MAX);
    semihost_exit(main(count, arguments));
}

static void unexpected(void)
{
    uint32_t number;
    __asm__ volatile("mrs %0, ipsr" : "=r"(number));
    char text[] = "exception 00\n";
    text[10] = (char)('0' + number / 10 % 10);
    text[11] = (char)('0' + number % 10);
    semihost_write(text);
    semihost_exit(1);
}

typedef void vector(void);
__attribute__((section(".vectors"), used)) static const struct {
    const uint32_t *stack;
    vector *exceptions[EXCEPTIONS - 1];
} vectors = {stack_top,
             {reset, unexpected, unexpected, unexpected, unexpected, unexpected, unexpected, unexpected,
              unexpected, unexpected, unexpected, unexpected, unexpected, unexpected, unexpected}};
