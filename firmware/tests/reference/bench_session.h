/* This header provides sessions on the test bench of a test file: single steps in LOCKSTEP, and a FREE_RUN
 * session that is recorded and replayed. A test includes this header after bench_fixture.h, once per file. */
#ifndef CRN_TEST_BENCH_SESSION_H
#define CRN_TEST_BENCH_SESSION_H

#include "firmware/tests/reference/bench_fixture.h"

enum { BENCH_SESSION_TICKS = 400 };

static crn_wire_live_tick session[BENCH_SESSION_TICKS];
static crn_wire_ticks ticks; /* the last answer to a step */

static void send_step(const crn_wire_step *step)
{
    static uint8_t payload[CRN_WIRE_BYTES_step];
    crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
    assert_true(crn_wire_put_step(&writer, step));
    client_send(&b.host, CRN_WIRE_TYPE_step, payload, writer.length);
}

static void start_lockstep(void)
{
    command(CRN_WIRE_ACTION_LOCKSTEP);
    command(CRN_WIRE_ACTION_ARM);
    command(CRN_WIRE_ACTION_START);
}

/* Starts FREE_RUN with a track that moves by 1 um per encoder count, without feedback from the motor. */
static inline void start_free_run(void)
{
    const crn_wire_track uncoupled = {.translation_pm_per_count = 1000000,
                                      .rotation_counts_per_turn = 65536,
                                      .force_gain_milli = 1000,
                                      .force_limit_mN = 8000,
                                      .torque_limit_uN_m = 20000};
    client_rig(&b.host, &uncoupled, 1);
    assert_true(client_expect_status(&b.host, &status));
    command(CRN_WIRE_ACTION_ARM);
    command(CRN_WIRE_ACTION_START);
}

/* Records ticks of FREE_RUN into `session`, and calls the function `meanwhile` before each tick. While the
 * ticks run, the host keeps sending messages, and reads the device's replies only afterwards. Returns the
 * number of ticks. */
static uint32_t record(void (*meanwhile)(int ms))
{
    static crn_wire_live live;
    uint32_t count = 0;
    for (int ms = 0; ms < BENCH_SESSION_TICKS; ms++) {
        meanwhile(ms);
        client_get(&b.host, CRN_WIRE_GET_STATUS);
        crn_sim_set_inputs(b.host.sim, &b.rig);
        crn_sim_timer(b.host.sim, 1);
    }
    for (uint16_t type = client_receive(&b.host); type != 0; type = client_receive(&b.host)) {
        if (type != CRN_WIRE_TYPE_live) continue;
        assert_true(crn_wire_decode_live(b.host.decoder.payload, b.host.decoder.payload_bytes, &live));
        for (uint16_t k = 0; k < live.ticks_count && count < BENCH_SESSION_TICKS; k++)
            session[count++] = live.ticks[k];
    }
    return count;
}

/* Checks that the recorded inputs give the same states, to the last bit, in LOCKSTEP. */
static void replays(uint32_t count)
{
    command(CRN_WIRE_ACTION_STOP);
    command(CRN_WIRE_ACTION_RESET);
    start_lockstep();
    for (uint32_t tick = 0; tick < count; tick++) {
        static crn_wire_step step;
        step = (crn_wire_step){.tick = tick, .inputs_count = 1};
        step.inputs[0] = session[tick].input;
        send_step(&step);
        assert_true(client_expect_ticks(&b.host, &ticks));
        assert_memory_equal(&ticks.states[0], &session[tick].state, sizeof ticks.states[0]);
    }
}

#endif
