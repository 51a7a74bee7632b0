/* These tests check a host's commands to heart and breath. In LOCKSTEP a command to the heart is part of a
 * tick's input, and a batch of inputs with one bad command is refused as a whole. In FREE_RUN a separate
 * message transmits a command to the heart. Each command to the heart is applied in a tick of its own, which
 * reports the command, and the session replays bit for bit. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/app/app.h"
#include "firmware/tests/reference/bench_session.h"

static crn_wire_reject reject;

static void ask(uint8_t action, uint16_t value)
{
    const crn_wire_order order = crn_wire_order_of_rhythm((crn_wire_rhythm){action, value});
    client_orders(&b.host, &order, 1);
}

/* Computes one tick in LOCKSTEP with a command to the heart; the tick's result is in `ticks`. */
static void step_asking(uint32_t tick, uint8_t action, uint16_t value)
{
    static crn_wire_step step;
    step = (crn_wire_step){.tick = tick, .inputs_count = 1};
    step.inputs[0] = (crn_wire_tick_input){.hands_count = 1};
    step.inputs[0].orders.items_count = action != 0;
    step.inputs[0].orders.items[0] = crn_wire_order_of_rhythm((crn_wire_rhythm){action, value});
    send_step(&step);
}

/* At the second tick, the input requests 140 beats a minute; the beat that follows the present beat is 428 ms
 * long. */
static void an_input_asks_at_its_own_tick(void **state)
{
    (void)state;
    start_lockstep();
    uint32_t beats = 0;
    for (uint32_t tick = 0; tick < 1500; tick++) {
        step_asking(tick, tick == 1 ? CRN_WIRE_RHYTHM_HEART_RATE : 0, tick == 1 ? 140 : 0);
        assert_true(client_expect_ticks(&b.host, &ticks));
        if (ticks.states[0].beat_ms != 0) continue;
        assert_int_equal(tick + 1, beats == 0 ? 857 : 857 + 428);
        assert_int_equal(ticks.states[0].interval_ms, 428);
        beats++;
    }
    assert_int_equal(beats, 2);
}

/* The batch has 20 inputs, of which the 13th commands 161 beats a minute, or an unknown action. */
static void a_batch_with_one_bad_request_is_refused_whole(void **state)
{
    (void)state;
    static const crn_wire_rhythm bad[] = {{CRN_WIRE_RHYTHM_HEART_RATE, 161}, {77, 1}, {0, 1}};
    start_lockstep();
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        static crn_wire_step step;
        step = (crn_wire_step){.tick = 0, .inputs_count = 20};
        for (int k = 0; k < 20; k++) step.inputs[k].hands_count = 1;
        step.inputs[12].orders.items_count = 1;
        step.inputs[12].orders.items[0] = crn_wire_order_of_rhythm(bad[i]);
        send_step(&step);
        assert_true(client_expect_reject(&b.host, &reject));
        assert_int_equal(reject.code, CRN_REJECT_ORDER_RANGE);
        assert_int_equal(reject.detail1, CRN_WIRE_KIND_rhythm);
        assert_int_equal(reject.detail2, 256 * 12);
        assert_int_equal(bench_status(&b).tick, 0);
    }
}

static void a_request_in_the_wrong_mode_state_or_range_is_refused(void **state)
{
    (void)state;
    bench_drain(&b);
    ask(CRN_WIRE_RHYTHM_HEART_RATE, 90);
    assert_true(client_expect_reject(&b.host, &reject));
    assert_int_equal(reject.code, CRN_REJECT_WRONG_STATE);
    command(CRN_WIRE_ACTION_LOCKSTEP);
    ask(CRN_WIRE_RHYTHM_HEART_RATE, 90);
    assert_true(client_expect_reject(&b.host, &reject));
    assert_int_equal(reject.code, CRN_REJECT_WRONG_MODE);
    command(CRN_WIRE_ACTION_FREE_RUN);
    assert_true(bench_power(&b));
    bench_drain(&b);
    static const crn_wire_rhythm bad[] = {{0, 0}, {CRN_WIRE_RHYTHM_BREATH_RATE, 21}, {7, 0}, {255, 65535}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        ask(bad[i].action, bad[i].value);
        assert_true(client_expect_reject(&b.host, &reject));
        assert_int_equal(reject.code, CRN_REJECT_ORDER_RANGE);
    }
    for (int i = 0; i < CRN_APP_ORDER_QUEUE; i++) {
        ask(CRN_WIRE_RHYTHM_HEART_RATE, (uint16_t)(80 + i));
        assert_true(client_expect_status(&b.host, &status));
    }
    ask(CRN_WIRE_RHYTHM_HEART_RATE, 90);
    assert_true(client_expect_reject(&b.host, &reject));
    assert_int_equal(reject.code, CRN_REJECT_ORDER_FULL);
}

static void ask_now_and_then(int ms)
{
    if (ms == 100) ask(CRN_WIRE_RHYTHM_PREMATURE, 500);
    if (ms == 100) ask(CRN_WIRE_RHYTHM_BREATH_HOLD, 1);
    if (ms == 300) ask(CRN_WIRE_RHYTHM_BREATH_HOLD, 0);
}

/* Two orders in one millisecond take two ticks; the recorded inputs give the same beats, hashes and phases in
 * LOCKSTEP. */
static void requests_of_free_run_replay_in_lockstep_bit_for_bit(void **state)
{
    (void)state;
    bench_drain(&b);
    start_free_run();
    const uint32_t count = record(ask_now_and_then);
    uint32_t asked = 0, last = 0;
    assert_true(count > 350);
    for (uint32_t i = 0; i < count; i++) {
        if (session[i].input.orders.items_count == 0) continue;
        if (++asked == 2) assert_int_equal(i, last + 1);
        last = i;
    }
    assert_int_equal(asked, 3);
    replays(count);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(an_input_asks_at_its_own_tick),
        TEST(a_batch_with_one_bad_request_is_refused_whole),
        TEST(a_request_in_the_wrong_mode_state_or_range_is_refused),
        TEST(requests_of_free_run_replay_in_lockstep_bit_for_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
