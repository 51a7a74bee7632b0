/* This file prints TAP lines, reads a clock, and reads one option. */
#define _POSIX_C_SOURCE 200809L
#include "hil_tests/library/check.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static int checks, failures;

bool check(bool good, const char *name)
{
    printf("%s %d - %s\n", good ? "ok" : "not ok", ++checks, name);
    fflush(stdout);
    failures += !good;
    return good;
}

void check_note(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("# ", stdout);
    vprintf(format, arguments);
    putchar('\n');
    fflush(stdout);
    va_end(arguments);
}

int check_end(void)
{
    printf("1..%d\n", checks);
    return failures == 0 && checks > 0 ? 0 : 1;
}

int64_t check_now_us(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000;
}

const char *check_serial(int argc, char **argv)
{
    if (argc == 1) return NULL;
    if (argc == 3 && strcmp(argv[1], "--serial") == 0) return argv[2];
    fprintf(stderr, "usage: %s [--serial NUMBER]\n", argv[0]);
    exit(2);
}
