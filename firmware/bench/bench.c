/* This file implements the command line of the benchmark programs (docs/bench.md). */
#define _POSIX_C_SOURCE 200809L
#include "firmware/bench/bench.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

void bench_fail(const char *sentence)
{
    fprintf(stderr, "benchmark: %s\n", sentence);
    exit(1);
}

double bench_now_us(void)
{
    struct timespec now;
    if (clock_gettime(CLOCK_MONOTONIC, &now) != 0) {
        bench_fail("the monotonic clock cannot be read");
    }
    return (double)now.tv_sec * 1e6 + (double)now.tv_nsec * 1e-3;
}

double bench_processor_ms(void)
{
    struct timespec now;
    if (clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now) != 0)
        bench_fail("the processor's clock cannot be read");
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

static int list(const bench_case *cases, size_t case_count)
{
    for (size_t i = 0; i < case_count; i++) {
        const bench_case *c = &cases[i];
        printf("%s\t%s\t%s\t", c->name, c->unit, c->context);
        if (c->function == NULL) {
            printf("value\n");
        } else {
            printf("callgrind:%s:%lu\n", c->function, c->calls);
        }
    }
    return 0;
}

int bench_main(int argc, char **argv, const bench_case *cases, size_t case_count)
{
    if (argc == 2 && strcmp(argv[1], "list") == 0) {
        return list(cases, case_count);
    }
    if (argc == 3 && strcmp(argv[1], "run") == 0) {
        char *end = NULL;
        unsigned long number = strtoul(argv[2], &end, 10);
        if (end != argv[2] && *end == '\0' && number < case_count) {
            printf("%.9g\n", cases[number].run(&cases[number]));
            return 0;
        }
    }
    fprintf(stderr, "usage: %s list | run CASE   (CASE: 0 to %zu)\n", argv[0], case_count - 1);
    return 2;
}
