/* This benchmark runs a million ticks in which random hand motions move tools in a vessel that forks. A third
 * of the benchmark's ticks has one tool, a third has two tools, and a third has three. Each row of the
 * results gives the largest length error of the tools, in percent. A row of the benchmark fails when a length
 * error exceeds 0.6 %. A row also fails when, in more than one tick in 10,000, the length error exceeds 0.45
 * % or a tool lies more than 1 mm beyond the wall. */
#include "firmware/bench/bench.h"
#include "firmware/tests/reference/random_hands.h"

#include <stdio.h>

enum { SESSIONS = 17, SESSION_TICKS = 20000 };

static double run_hands(const bench_case *self)
{
    reference_hands_result r = {0};
    for (uint32_t i = 0; i < SESSIONS; i++) {
        reference_random_hands((uint32_t)self->argument, 3 * i + (uint32_t)self->argument - 1, SESSION_TICKS,
                               &r);
        fprintf(stderr,
                "%d tools, %d of %d sessions: %d ticks, length error at most %.3f %%, above 0.45 %% in %d, "
                "depth at most "
                "%.2f mm, above 1 mm in %d\n",
                self->argument, (int)i + 1, SESSIONS, r.ticks, r.strain_max_pct, r.long_045, r.depth_max_mm,
                r.deep);
    }
    if (r.strain_max_pct > 0.6 || r.long_045 > r.ticks / 10000 || r.deep > r.ticks / 10000)
        bench_fail("the line does not stay whole and in the vessel");
    return r.strain_max_pct;
}

#define HANDS(tools)                                                                                         \
    {                                                                                                        \
        "hands.length_error_max_pct", "%",                                                                   \
            "tools=" #tools " ticks=335000 random hands to 0.5 m/s, 12 rad/s", NULL, 0, run_hands, tools     \
    }

static const bench_case cases[] = {HANDS(1), HANDS(2), HANDS(3)};

int main(int argc, char **argv)
{
    return bench_main(argc, argv, cases, sizeof cases / sizeof cases[0]);
}
