/* A benchmark program consists of a table of cases and a `main` that follows the convention of docs/bench.md.
 * This header declares the table of cases and the function that runs a benchmark program. */
#ifndef CRN_BENCH_H
#define CRN_BENCH_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#define BENCH_NORETURN [[noreturn]]
#else
#define BENCH_NORETURN _Noreturn
#endif

/* Marks a function that callgrind must find by name: the compiler neither inlines nor clones it. */
#if defined(__clang__)
#define BENCH_MEASURED __attribute__((noinline, used))
#else
#define BENCH_MEASURED __attribute__((noinline, noclone, used))
#endif

typedef struct bench_case bench_case;
struct bench_case {
    const char *name;     /* "rod.step_instructions" */
    const char *unit;     /* "instructions", "us", "%" */
    const char *context;  /* "elements=256 contacts=57" */
    const char *function; /* the function that callgrind counts, or NULL: the value is what `run` returns */
    unsigned long calls;  /* number of calls of `function` by `run` */
    double (*run)(const bench_case *self);
    int argument; /* free for the case's own use */
};

/* Ends the program with exit code 1 and a message, for a case that cannot be measured. */
BENCH_NORETURN void bench_fail(const char *sentence);

/* Monotonic clock in microseconds. */
double bench_now_us(void);

/* Processor time of all threads of this process in milliseconds, which other programs do not influence. Ends
 * the program where the clock cannot be read. */
double bench_processor_ms(void);

/* Runs the benchmark program's command line, where `list` prints the cases and `run N` runs case N. Returns
 * the exit code: 0 ok, 2 usage. */
int bench_main(int argc, char **argv, const bench_case *cases, size_t case_count);

#ifdef __cplusplus
}
#endif

#endif
