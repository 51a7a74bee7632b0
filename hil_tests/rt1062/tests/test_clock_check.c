/* Claim: the board's check of its timer against the frames of USB finds every wrong ratio of the two clocks,
 * soon, and takes no reset, no suspended bus and no busy processor for a wrong clock. The check is called at
 * every edge. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/port/imxrt1062/clock_check.c"

enum { EDGES = 20000, SOON_edges = 150, SOON_frames = 3 };

typedef struct bus {
    double frames; /* since the first call */
    uint32_t edges;
} bus;

static void begin_bus(bus *b)
{
    memset(&window, 0, sizeof window);
    *b = (bus){0, 0};
}

/* Lets so many edges come, each with so many frames. Returns the edge at which the check finds a difference,
 * or 0. */
static uint32_t run(bus *b, uint32_t edges, double frames_per_edge)
{
    for (uint32_t i = 1; i <= edges; i++) {
        b->edges++;
        b->frames += frames_per_edge;
        if (clock_check(b->edges, (uint32_t)((uint64_t)b->frames % FRAMES)) != 0) return i;
    }
    return 0;
}

/* Requirement: SR-26 */
static void every_wrong_ratio_of_the_clocks_is_found_soon(void **state)
{
    (void)state;
    static const double slow[] = {0.0005, 1 / 64.0, 1 / 20.0, 0.051, 0.06, 0.1, 0.5, 0.9, 0.93};
    static const double fast[] = {1.07, 1.1,  2,  9,  15.9, 16,  16.1, 17,  17.05,
                                  19,   19.9, 20, 33, 64,   128, 1000, 2047};
    bus b;
    for (size_t i = 0; i < sizeof slow / sizeof *slow; i++) {
        begin_bus(&b);
        const uint32_t found = run(&b, EDGES, slow[i]);
        const double soon = SOON_frames / slow[i] > SOON_edges ? SOON_frames / slow[i] + 1 : SOON_edges;
        if (found == 0 || found > soon) fail_msg("%g frames an edge: edge %u", slow[i], (unsigned)found);
    }
    for (size_t i = 0; i < sizeof fast / sizeof *fast; i++) {
        begin_bus(&b);
        const uint32_t found = run(&b, EDGES, fast[i]);
        if (found == 0 || found > SOON_edges)
            fail_msg("%g frames an edge: edge %u", fast[i], (unsigned)found);
    }
}

/* Both crystals together are within 0.1 %. */
static void good_clocks_are_never_wrong(void **state)
{
    (void)state;
    bus b;
    for (int ppm = -1000; ppm <= 1000; ppm += 250) {
        begin_bus(&b);
        assert_int_equal(run(&b, EDGES, 1 + ppm * 1e-6), 0);
    }
}

static void suspended_bus_and_busy_processor_are_no_wrong_clock(void **state)
{
    (void)state;
    bus b;
    begin_bus(&b);
    for (int i = 0; i < 40; i++) {
        assert_int_equal(run(&b, 300, 1), 0);
        assert_int_equal(run(&b, 25 + 37 * (uint32_t)i, 0), 0); /* the bus is suspended */
        assert_int_equal(run(&b, 5, 1), 0);
        b.frames += 21 + 31 * i; /* the processor stands still; its timer's edges are lost */
        assert_int_equal(run(&b, 5, 1), 0);
        b.frames += 90, b.edges += 90; /* the loop was busy, and its interrupts counted the edges */
        assert_int_equal(run(&b, 1, 1), 0);
        b.frames += 60, b.edges += 60;
        assert_int_equal(run(&b, 5, 1), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_wrong_ratio_of_the_clocks_is_found_soon),
        cmocka_unit_test(good_clocks_are_never_wrong),
        cmocka_unit_test(suspended_bus_and_busy_processor_are_no_wrong_clock),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
