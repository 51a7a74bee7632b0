/* This header provides a test bench to all tests of a file and opens it anew for each test. The fixture has
 * the functions set_up and tear_down for cmocka, and a function that sends a command and reads the answer. A
 * test includes this header after cmocka.h, once per file. */
#ifndef CRN_TEST_BENCH_FIXTURE_H
#define CRN_TEST_BENCH_FIXTURE_H

#include "firmware/tests/reference/bench.h"

static bench b;
static crn_wire_status status; /* the last answer */

static int set_up(void **state)
{
    (void)state;
    return bench_open(&b) ? 0 : 1;
}

static int tear_down(void **state)
{
    (void)state;
    bench_close(&b);
    return 0;
}

static inline void command(uint8_t action)
{
    bench_drain(&b);
    client_command(&b.host, action);
    assert_true(client_expect_status(&b.host, &status));
}

#endif
