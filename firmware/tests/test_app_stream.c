/* These tests check the messages that the device sends without a request. When the pipe to the host is full,
 * the device in FREE_RUN drops a picture of the tools rather than a tick, and reports the loss. Notices
 * report which event happened at which tick, and a STOP takes effect at the tick that it names. A replay of a
 * FREE_RUN session in LOCKSTEP gives the same results bit for bit. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/app/app.h"
#include "firmware/tests/reference/bench_fixture.h"

static client *const host = &b.host;

/* --- stream --- */

/* The pipe to the host has space for little more than the ticks: pictures are dropped and counted, but no
 * tick is dropped. */
static void a_slow_host_loses_pictures_and_no_tick(void **state)
{
    (void)state;
    static crn_wire_live live;
    uint32_t tick = 0, pictures = 0;
    crn_sim_set_pipe(host->sim, 12100);
    assert_true(bench_power(&b));
    bench_drain(&b);
    client_stream(host, 0, 10);
    assert_true(client_expect_status(host, &status));
    tick = bench_status(&b).tick;
    const uint32_t begin = tick / 16 * 16; /* frames in the queue still have to arrive */
    tick = begin;
    for (int i = 0; i < 2000; i++) {
        crn_sim_timer(host->sim, 1);
        if (i % 60 != 59) continue;
        for (uint16_t type = client_receive(host); type != 0; type = client_receive(host)) {
            pictures += type == CRN_WIRE_TYPE_nodes;
            if (type != CRN_WIRE_TYPE_live) continue;
            assert_true(crn_wire_decode_live(host->decoder.payload, host->decoder.payload_bytes, &live));
            assert_int_equal(live.ticks_lost, 0);
            for (uint16_t k = 0; k < live.ticks_count; k++)
                assert_int_equal(live.ticks[k].state.tick, ++tick);
        }
    }
    crn_sim_set_pipe(host->sim, 1 << 20);
    crn_sim_timer(host->sim, 40);
    status = bench_status(&b);
    print_message("# %u ticks, %u pictures sent, %u dropped\n", tick - begin, pictures,
                  status.pictures_dropped);
    assert_true(tick > 1900 && pictures > 10 && status.pictures_dropped > 100);
    assert_int_equal(status.ticks_lost, 0);
}

/* The host does not read for a second and then reads again. While the host did not read, the device kept only
 * the last 256 ticks, so it reports a gap in the ticks; all other messages arrive in order. */
static void ticks_that_nobody_takes_are_counted_as_lost(void **state)
{
    (void)state;
    static crn_wire_live live;
    crn_wire_fault_entry entry;
    assert_true(bench_power(&b));
    crn_sim_timer(host->sim, 40);
    bench_drain(&b);
    crn_sim_set_pipe(host->sim, 0);
    crn_sim_timer(host->sim, 1000);
    crn_sim_set_pipe(host->sim, 1 << 20);
    crn_sim_timer(host->sim, 16);
    uint32_t ticks = 0, last = 0;
    while (client_expect_live(host, &live)) {
        for (uint16_t k = 0; k < live.ticks_count; k++, ticks++) {
            if (last != 0) assert_int_equal(live.ticks[k].state.tick, last + 1);
            last = live.ticks[k].state.tick;
        }
    }
    assert_true(ticks >= CRN_APP_LIVE_QUEUE_ticks);
    assert_int_equal(live.ticks_lost, bench_status(&b).ticks_lost);
    assert_true(live.ticks_lost > 700);
    assert_int_equal(bench_fault(&b, CRN_FAULT_CODE_TICKS_LOST, &entry), live.ticks_lost);
}

static void notices_tell_what_happened_at_which_tick(void **state)
{
    (void)state;
    crn_wire_notice notice;
    bench_drain(&b);
    client_stream(host, 1, 0);
    assert_true(client_expect_status(host, &status));
    assert_true(bench_power(&b));
    b.host_speaks = false; /* and it does not read */
    crn_sim_timer(host->sim, 100);
    b.rig.buttons = CRN_WIRE_BUTTON_XRAY;
    bench_tick(&b);
    b.rig.emergency_stop = true;
    bench_tick(&b);
    bench_tick(&b);
    uint32_t kinds[8] = {0}, number = 0;
    bool saw_silence = false, saw_pedal = false, saw_stop = false;
    crn_sim_timer(host->sim, 20);
    for (uint16_t type = client_receive(host); type != 0; type = client_receive(host)) {
        if (type != CRN_WIRE_TYPE_notice) continue;
        assert_true(crn_wire_decode_notice(host->decoder.payload, host->decoder.payload_bytes, &notice));
        assert_true(notice.number > number);
        number = notice.number;
        kinds[notice.kind % 8]++;
        saw_silence |= notice.kind == CRN_WIRE_EVENT_HOST && notice.code == 1;
        saw_pedal |= notice.kind == CRN_WIRE_EVENT_BUTTONS && notice.value1 == CRN_WIRE_BUTTON_XRAY;
        saw_stop |= notice.kind == CRN_WIRE_EVENT_FAULT && notice.code == CRN_FAULT_CODE_EMERGENCY_STOP;
    }
    assert_true(saw_silence && saw_pedal && saw_stop);
    assert_true(kinds[CRN_WIRE_EVENT_STATE] >= 1);
}

static void events_that_nobody_takes_are_counted_as_lost(void **state)
{
    (void)state;
    bench_drain(&b);
    client_stream(host, 1, 0);
    assert_true(client_expect_status(host, &status));
    assert_true(bench_power(&b));
    bench_drain(&b);
    crn_sim_set_pipe(host->sim, 0);
    for (uint32_t i = 1; i < 60; i++) {
        b.rig.buttons = i;
        crn_sim_set_inputs(host->sim, &b.rig);
        crn_sim_timer(host->sim, 1);
    }
    crn_sim_set_pipe(host->sim, 1 << 20);
    status = bench_status(&b);
    assert_true(status.events_lost >= 59 - CRN_APP_EVENT_QUEUE);
    assert_int_equal(bench_fault(&b, CRN_FAULT_CODE_EVENTS_LOST, NULL), bench_status(&b).events_lost);
}

/* STOP at a later tick, in FREE_RUN and in the middle of a batch of LOCKSTEP. */
static void a_stop_is_carried_out_at_its_tick(void **state)
{
    (void)state;
    static crn_wire_ticks ticks;
    assert_true(bench_power(&b));
    const uint32_t at = bench_status(&b).tick + 30;
    client_stop_at(host, at);
    assert_true(client_expect_status(host, &status));
    assert_int_equal(status.state, CRN_WIRE_STATE_RUNNING);
    for (int i = 0; i < 60; i++) bench_tick(&b);
    status = bench_status(&b);
    assert_int_equal(status.state, CRN_WIRE_STATE_ARMED);
    assert_int_equal(status.tick, at);
    assert_int_equal(crn_sim_read_motors(host->sim).drive, 0);
    command(CRN_WIRE_ACTION_LOCKSTEP);
    command(CRN_WIRE_ACTION_START);
    client_stop_at(host, at + 5);
    assert_true(client_expect_status(host, &status));
    client_step(host, at, 20, b.rig.hands[0].translation_counts, 0);
    assert_true(client_expect_ticks(host, &ticks));
    assert_int_equal(ticks.states_count, 5);
    assert_int_equal(bench_status(&b).state, CRN_WIRE_STATE_ARMED);
}

/* --- replay --- */

static crn_wire_live_tick session[600];

/* In this test the hand pushes, turns and trembles, and feels the tool through the coupling and the friction
 * of the seal. If a session in LOCKSTEP gets the inputs of a FREE_RUN session, it must give the same hashes,
 * forces and motor values in every tick. */
static void free_run_replays_in_lockstep_bit_for_bit(void **state)
{
    (void)state;
    static crn_wire_live live;
    static crn_wire_ticks ticks;
    uint32_t count = 0, random = 1;
    crn_wire_track track = client_plain_track();
    track.seal_mN = 40;
    track.seal_uN_m = 20;
    for (int run = 0; run < 2; run++) {
        bench_drain(&b);
        client_rig(host, &track, 1);
        assert_true(client_expect_status(host, &status));
        if (run == 1) break;
        client_command(host, CRN_WIRE_ACTION_ARM);
        assert_true(client_expect_status(host, &status));
        assert_true(client_arm_motors(host));
        command(CRN_WIRE_ACTION_START);
        for (int i = 0; i < 600; i++) {
            random = random * 1664525u + 1013904223u;
            b.rig.hands[0].translation_counts += (int32_t)(random >> 24) - (i < 300 ? 80 : 160);
            b.rig.hands[0].rotation_counts += (int32_t)(random >> 16 & 127) - 50;
            client_get(host, CRN_WIRE_GET_STATUS);
            crn_sim_set_inputs(host->sim, &b.rig);
            crn_sim_timer(host->sim, 1);
        }
        for (uint16_t type = client_receive(host); type != 0; type = client_receive(host)) {
            if (type != CRN_WIRE_TYPE_live) continue;
            assert_true(crn_wire_decode_live(host->decoder.payload, host->decoder.payload_bytes, &live));
            for (uint16_t k = 0; k < live.ticks_count; k++) session[count++] = live.ticks[k];
        }
        assert_true(count >= 580);
        bench_close(&b);
        assert_true(bench_open(&b));
    }
    command(CRN_WIRE_ACTION_LOCKSTEP);
    command(CRN_WIRE_ACTION_ARM);
    command(CRN_WIRE_ACTION_START);
    int32_t largest_mN = 0;
    for (uint32_t tick = 0; tick < count; tick++) {
        const crn_wire_hand *hand = &session[tick].input.hands[0];
        uint8_t payload[64];
        static crn_wire_step step;
        step = (crn_wire_step){.tick = tick, .inputs_count = 1};
        step.inputs[0] = session[tick].input;
        assert_int_equal(session[tick].state.tick, tick + 1);
        assert_true(hand->translation_counts != 0 || tick < 2);
        crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
        assert_true(crn_wire_put_step(&writer, &step));
        client_send(host, CRN_WIRE_TYPE_step, payload, writer.length);
        assert_true(client_expect_ticks(host, &ticks));
        assert_memory_equal(&ticks.states[0], &session[tick].state, sizeof ticks.states[0]);
        int32_t mN = abs(ticks.states[0].tools[0].motor_axial_mN);
        largest_mN = mN > largest_mN ? mN : largest_mN;
    }
    print_message("# %u ticks, forces up to %d mN\n", count, largest_mN);
    assert_true(largest_mN > 40);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_slow_host_loses_pictures_and_no_tick),   TEST(ticks_that_nobody_takes_are_counted_as_lost),
        TEST(notices_tell_what_happened_at_which_tick), TEST(events_that_nobody_takes_are_counted_as_lost),
        TEST(a_stop_is_carried_out_at_its_tick),        TEST(free_run_replays_in_lockstep_bit_for_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
