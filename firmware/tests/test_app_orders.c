/* These tests check the list of commands ("orders") to the core that the input of a tick can contain. A list
 * of commands is accepted or refused as a whole, with a code that says which command is wrong, and hostile
 * bytes change nothing. In FREE_RUN all commands of one message are applied in one tick, and the tick reports
 * them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/app/app.h"
#include "firmware/tests/reference/bench_session.h"

static crn_wire_reject reject;

static crn_wire_order heart_rate(uint16_t per_minute)
{
    return crn_wire_order_of_rhythm((crn_wire_rhythm){CRN_WIRE_RHYTHM_HEART_RATE, per_minute});
}

static crn_wire_order ring(uint8_t number)
{
    return crn_wire_order_of_strut(
        (crn_wire_strut){number, number < 64, 0, 20000 + 1000 * number, 0, 1500, 80});
}

static void expect_refusal(uint16_t code, uint32_t detail1, uint32_t detail2)
{
    assert_true(client_expect_reject(&b.host, &reject));
    assert_int_equal(reject.code, code);
    assert_int_equal(reject.detail1, detail1);
    assert_int_equal(reject.detail2, detail2);
}

static void start_free(void)
{
    bench_drain(&b);
    start_free_run();
    bench_drain(&b);
}

/* Checks that in the next `ticks_wanted` ticks the device reports the given numbers of commands. */
static void expect_counts(const uint16_t *counts, uint32_t ticks_wanted)
{
    static crn_wire_live live;
    uint32_t seen = 0;
    crn_sim_timer(b.host.sim, 16);
    for (uint16_t type = client_receive(&b.host); type != 0; type = client_receive(&b.host)) {
        if (type != CRN_WIRE_TYPE_live) continue;
        assert_true(crn_wire_decode_live(b.host.decoder.payload, b.host.decoder.payload_bytes, &live));
        for (uint16_t k = 0; k < live.ticks_count && seen < ticks_wanted; k++, seen++)
            assert_int_equal(live.ticks[k].input.orders.items_count, counts[seen]);
    }
    assert_int_equal(seen, ticks_wanted);
}

static void a_step_with_two_orders_of_a_kind_is_refused_whole(void **state)
{
    (void)state;
    static crn_wire_step step;
    start_lockstep();
    step = (crn_wire_step){.tick = 0, .inputs_count = 4};
    for (int k = 0; k < 4; k++) step.inputs[k].hands_count = 1;
    step.inputs[3].orders = (crn_wire_order_list){3, {ring(1), heart_rate(90), ring(2)}};
    send_step(&step);
    expect_refusal(CRN_REJECT_ORDER_TWICE, CRN_WIRE_KIND_strut, 3 * 256 + 2);
    assert_int_equal(bench_status(&b).tick, 0);
    step.inputs[3].orders.items_count = 2;
    send_step(&step);
    assert_true(client_expect_ticks(&b.host, &ticks));
    assert_int_equal(ticks.states_count, 4);
}

static void a_good_order_does_not_pass_beside_a_bad_one(void **state)
{
    (void)state;
    start_free();
    const crn_wire_order twice[] = {heart_rate(90), ring(1), heart_rate(91)};
    client_orders(&b.host, twice, 3);
    expect_refusal(CRN_REJECT_ORDER_TWICE, CRN_WIRE_KIND_rhythm, 2);
    const crn_wire_order out_of_range[] = {heart_rate(90), ring(65)};
    client_orders(&b.host, out_of_range, 2);
    expect_refusal(CRN_REJECT_ORDER_RANGE, CRN_WIRE_KIND_strut, 1);
    const crn_wire_order no_lesion = crn_wire_order_of_scaffold((crn_wire_scaffold){1, 0, 0, 32768});
    client_orders(&b.host, &no_lesion, 1);
    expect_refusal(CRN_REJECT_ORDER_RANGE, CRN_WIRE_KIND_scaffold, 0);
    expect_counts((const uint16_t[16]){0}, 16);
}

/* Sends variants of a valid message: cut at every byte, with every invalid kind of command, and with a count
 * that is too large. */
static void hostile_bytes_are_malformed_and_order_nothing(void **state)
{
    (void)state;
    uint8_t good[CRN_WIRE_BYTES_orders];
    crn_wire_writer writer = crn_wire_writer_make(good, sizeof good);
    const crn_wire_orders message = {.orders = {2, {ring(1), heart_rate(90)}}};
    assert_true(crn_wire_put_orders(&writer, &message));
    start_free();
    for (size_t cut = 0; cut < writer.length; cut++) {
        client_send(&b.host, CRN_WIRE_TYPE_orders, good, cut);
        expect_refusal(CRN_REJECT_MALFORMED, (uint32_t)cut, CRN_WIRE_BYTES_orders);
    }
    for (unsigned kind = 0; kind < 256; kind += kind < 8 ? 1 : 13) {
        if (kind == CRN_WIRE_KIND_strut) continue;
        good[1] = (uint8_t)kind;
        client_send(&b.host, CRN_WIRE_TYPE_orders, good, writer.length);
        expect_refusal(CRN_REJECT_MALFORMED, (uint32_t)writer.length, CRN_WIRE_BYTES_orders);
    }
    good[1] = CRN_WIRE_KIND_strut;
    good[0] = CRN_WIRE_MAX_order_list_items + 1;
    client_send(&b.host, CRN_WIRE_TYPE_orders, good, sizeof good);
    expect_refusal(CRN_REJECT_MALFORMED, sizeof good, CRN_WIRE_BYTES_orders);
    expect_counts((const uint16_t[16]){0}, 16);
}

/* In version 4 of the wire protocol, each message contained one command; the message types in this test
 * belong to that version. */
static void messages_of_the_protocol_before_are_unknown(void **state)
{
    (void)state;
    static const uint8_t zeros[18];
    start_free();
    for (uint16_t type = 0x28; type <= 0x29; type++) {
        client_send(&b.host, type, zeros, type == 0x28 ? 5 : sizeof zeros);
        expect_refusal(CRN_REJECT_UNKNOWN_TYPE, type, 0);
    }
}

static void orders_have_their_own_message_in_free_run(void **state)
{
    (void)state;
    start_free();
    client_orders(&b.host, NULL, 0);
    expect_refusal(CRN_REJECT_ORDER_MISPLACED, 0, 0);
    uint8_t payload[CRN_WIRE_BYTES_input];
    crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
    const crn_wire_input input = {.input = {.hands_count = 1, .orders = {1, {heart_rate(90)}}}};
    assert_true(crn_wire_put_input(&writer, &input));
    client_send(&b.host, CRN_WIRE_TYPE_input, payload, writer.length);
    expect_refusal(CRN_REJECT_ORDER_MISPLACED, 1, 0);
    expect_counts((const uint16_t[16]){0}, 16);
}

/* The device can keep the commands of eight future ticks. After eight messages with commands, the device
 * refuses the ninth and keeps the first eight unchanged; after a tick, the device accepts a message again. */
static void a_full_queue_refuses_and_keeps_what_waits(void **state)
{
    (void)state;
    start_free();
    for (uint32_t i = 0; i < CRN_APP_ORDER_QUEUE; i++) {
        const crn_wire_order orders[] = {ring((uint8_t)(i + 1)), heart_rate((uint16_t)(80 + i))};
        client_orders(&b.host, orders, i % 2 == 0 ? 2 : 1);
        assert_true(client_expect_status(&b.host, &status));
    }
    const crn_wire_order late = heart_rate(100);
    client_orders(&b.host, &late, 1);
    expect_refusal(CRN_REJECT_ORDER_FULL, CRN_WIRE_KIND_rhythm, CRN_APP_ORDER_QUEUE);
    crn_sim_timer(b.host.sim, 1);
    client_orders(&b.host, &late, 1);
    assert_true(client_expect_status(&b.host, &status));
    expect_counts((const uint16_t[16]){2, 1, 2, 1, 2, 1, 2, 1, 1}, 16);
}

/* Sends two kinds of commands in one tick, and then a command in every tick until the ring buffer of bytes
 * has wrapped. */
static void order_all_the_time(int ms)
{
    const crn_wire_order orders[] = {ring((uint8_t)(ms % 64 + 1)), heart_rate((uint16_t)(60 + ms % 60))};
    client_orders(&b.host, orders, ms % 10 == 0 ? 2 : 1);
}

static void orders_of_free_run_replay_in_lockstep_bit_for_bit(void **state)
{
    (void)state;
    bench_drain(&b);
    start_free_run();
    const uint32_t count = record(order_all_the_time);
    uint32_t orders = 0;
    assert_true(count > 350);
    for (uint32_t i = 0; i < count; i++) {
        assert_int_equal(session[i].input.orders.items_count, i % 10 == 0 ? 2 : 1);
        assert_int_equal(session[i].input.orders.items[0].strut.number, i % 64 + 1);
        orders += session[i].input.orders.items_count;
    }
    assert_true(orders > count);
    replays(count);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_step_with_two_orders_of_a_kind_is_refused_whole),
        TEST(a_good_order_does_not_pass_beside_a_bad_one),
        TEST(hostile_bytes_are_malformed_and_order_nothing),
        TEST(messages_of_the_protocol_before_are_unknown),
        TEST(orders_have_their_own_message_in_free_run),
        TEST(a_full_queue_refuses_and_keeps_what_waits),
        TEST(orders_of_free_run_replay_in_lockstep_bit_for_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
