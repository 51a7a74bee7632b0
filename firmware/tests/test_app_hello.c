/* These tests check what happens when a second program connects to a rig that has power, and which events
 * reset a port's watchdog. A second program that connects does not disturb the program that is in control. If
 * the program in control has gone, the next program can take over. Only timer edges that the app has
 * completed reset the watchdog. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "firmware/app/app.h"
#include "firmware/tests/reference/bench_fixture.h"

enum { FORCE_mN = 1500 };

static crn_wire_reject reject;

static void power_and_push(void)
{
    assert_true(bench_power(&b));
    assert_true(bench_push(&b, FORCE_mN));
}

/* The library of any host opens with HELLO, and sends RESET to a device that is not READY. The refusal of
 * HELLO prevents that RESET. */
static void a_second_program_is_refused_while_the_first_leads_with_power(void **state)
{
    (void)state;
    power_and_push();
    for (int i = 0; i < 10; i++) {
        bench_drain(&b);
        client_hello(&b.host, crn_wire_schema_hash());
        assert_true(client_expect_reject(&b.host, &reject));
        assert_int_equal(reject.request_type, CRN_WIRE_TYPE_hello);
        assert_int_equal(reject.code, CRN_REJECT_BUSY);
        bench_tick(&b);
    }
    assert_int_equal(crn_sim_read_motors(b.host.sim).drive, 1);
    assert_true(crn_sim_read_motors(b.host.sim).axial_mN[0] >= FORCE_mN / 2);
    /* and the device still obeys the first program */
    assert_int_equal(bench_status(&b).state, CRN_WIRE_STATE_RUNNING);
}

/* A refused HELLO does not count as a message of the program in control; when that program is silent, the
 * forces end in the usual time. */
static void a_refused_hello_does_not_keep_the_forces_of_a_dead_host(void **state)
{
    (void)state;
    int edges = 0;
    power_and_push();
    b.host_speaks = false;
    client_get(&b.host, CRN_WIRE_GET_STATUS); /* the last word */
    bench_drain(&b);
    for (bool is_refused = true; is_refused && edges < 200; edges++) {
        bench_tick(&b);
        bench_drain(&b);
        client_hello(&b.host, crn_wire_schema_hash());
        is_refused = client_receive(&b.host) == CRN_WIRE_TYPE_reject;
    }
    assert_in_range(edges, CRN_APP_HOST_SILENT_ticks, CRN_APP_HOST_SILENT_ticks + CRN_APP_FADE_ticks + 1);
}

/* When a crashed program has been silent so long that the forces have ended, this program is no longer in
 * control; the next program sends HELLO and RESET, and begins its session. */
static void after_a_host_that_is_gone_hello_works(void **state)
{
    (void)state;
    power_and_push();
    b.host_speaks = false;
    for (int i = 0; i < CRN_APP_HOST_SILENT_ticks + CRN_APP_FADE_ticks; i++) bench_tick(&b);
    assert_true(bench_is_safe(&b));
    bench_drain(&b);
    client_hello(&b.host, crn_wire_schema_hash());
    assert_int_equal(client_receive(&b.host), CRN_WIRE_TYPE_hello_reply);
    b.host_speaks = true;
    command(CRN_WIRE_ACTION_RESET);
    assert_int_equal(status.state, CRN_WIRE_STATE_READY);
    assert_true(bench_power(&b));
}

/* STOP, or a fault that stops the device, also ends a program's control. */
static void after_stop_hello_works_at_once(void **state)
{
    (void)state;
    power_and_push();
    command(CRN_WIRE_ACTION_STOP);
    client_hello(&b.host, crn_wire_schema_hash());
    assert_int_equal(client_receive(&b.host), CRN_WIRE_TYPE_hello_reply);
}

static void without_power_a_second_hello_is_answered(void **state)
{
    (void)state;
    command(CRN_WIRE_ACTION_LOCKSTEP);
    command(CRN_WIRE_ACTION_ARM);
    command(CRN_WIRE_ACTION_START);
    client_hello(&b.host, crn_wire_schema_hash());
    assert_int_equal(client_receive(&b.host), CRN_WIRE_TYPE_hello_reply);
    assert_int_equal(bench_status(&b).state, CRN_WIRE_STATE_RUNNING);
}

/* --- the watchdog --- */

static crn_app app;
static jmp_buf stuck;
static bool hangs;

static bool swallow(void *context, const uint8_t *frame, size_t bytes)
{
    (void)context;
    (void)frame;
    return bytes > 0;
}

static size_t room(void *context)
{
    (void)context;
    return SIZE_MAX / 2;
}

static bool no_rig(void *context, crn_port_inputs *inputs)
{
    (void)context;
    (void)inputs;
    return false;
}

static uint32_t no_time(void *context)
{
    (void)context;
    return 0;
}

/* To simulate app code that never returns, the test jumps out of the code that handles an edge of the timer
 * (longjmp); the test can then continue. */
static void outputs(void *context, const crn_port_outputs *wanted)
{
    (void)context;
    (void)wanted;
    if (hangs) longjmp(stuck, 1);
}

static const crn_port port = {.transmit = swallow,
                              .transmit_room = room,
                              .inputs = no_rig,
                              .outputs = outputs,
                              .now_us = no_time,
                              .serial = "stuck"};

/* Requirement: SR-21 */
static void only_an_edge_done_to_its_end_counts_for_the_watchdog(void **state)
{
    (void)state;
    static const uint8_t bytes[600] = {1, 2, 3};
    hangs = false;
    crn_app_init(&app, &port);
    assert_int_equal(app.edges_done, 0);
    for (uint32_t i = 1; i <= 5; i++) {
        crn_app_timer(&app);
        assert_int_equal(app.edges_done, i);
    }
    for (int i = 0; i < 100; i++) crn_app_receive(&app, bytes, sizeof bytes); /* a busy host is not a tick */
    assert_int_equal(app.edges_done, 5);
    hangs = true;
    if (setjmp(stuck) == 0) {
        crn_app_timer(&app);
        fail_msg("the edge ended");
    }
    assert_int_equal(app.edges_done, 5);
    hangs = false;
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_second_program_is_refused_while_the_first_leads_with_power),
        TEST(a_refused_hello_does_not_keep_the_forces_of_a_dead_host),
        TEST(after_a_host_that_is_gone_hello_works),
        TEST(after_stop_hello_works_at_once),
        TEST(without_power_a_second_hello_is_answered),
        cmocka_unit_test(only_an_edge_done_to_its_end_counts_for_the_watchdog),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
