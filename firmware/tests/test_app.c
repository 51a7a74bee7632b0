/* These tests check the app through the bytes of the simulated port. States and modes follow the diagram of
 * app.h, refusals have an error code and change nothing, and encoder jumps stop the session. The tests also
 * check that forces stay within their limits, and that a session restored from a snapshot continues with
 * exactly the same results. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/app/app.h"
#include "firmware/tests/reference/client.h"

static client host;
static crn_wire_status status;
static crn_wire_reject reject;
static crn_wire_ticks ticks;
static crn_wire_tools tools;

static int set_up(void **state)
{
    (void)state;
    client_open(&host, 1 << 20);
    return host.sim == NULL;
}

static int tear_down(void **state)
{
    (void)state;
    client_close(&host);
    return 0;
}

static void expect_reject(uint16_t code)
{
    assert_true(client_expect_reject(&host, &reject));
    if (reject.code != code) {
        fail_msg("refused with %s, expected %s", crn_wire_reject_name(reject.code),
                 crn_wire_reject_name(code));
    }
}

static void expect_state(uint8_t expected)
{
    client_get(&host, CRN_WIRE_GET_STATUS);
    assert_true(client_expect_status(&host, &status));
    if (status.state != expected) {
        fail_msg("state %s, expected %s", crn_wire_state_name(status.state), crn_wire_state_name(expected));
    }
}

/* --- identity --- */

static void nothing_is_answered_before_hello(void **state)
{
    (void)state;
    client_get(&host, CRN_WIRE_GET_STATUS);
    expect_reject(CRN_REJECT_NOT_GREETED);
}

static void another_schema_hash_is_refused_and_both_are_known(void **state)
{
    (void)state;
    crn_wire_hello_reply reply;
    client_hello(&host, crn_wire_schema_hash() ^ 1);
    assert_int_equal(client_receive(&host), CRN_WIRE_TYPE_hello_reply);
    assert_true(crn_wire_decode_hello_reply(host.decoder.payload, host.decoder.payload_bytes, &reply));
    assert_int_equal(reply.accepted, 0);
    assert_true(reply.schema_hash == crn_wire_schema_hash());
    client_command(&host, CRN_WIRE_ACTION_ARM);
    expect_reject(CRN_REJECT_NOT_GREETED);
}

static void replies_name_the_request_they_answer(void **state)
{
    (void)state;
    assert_true(client_start_session(&host));
    client_get(&host, CRN_WIRE_GET_STATUS);
    assert_true(client_expect_status(&host, &status));
    assert_int_equal(host.decoder.header.answers, host.sequence);
}

static void missing_frames_are_counted(void **state)
{
    (void)state;
    assert_true(client_start_session(&host));
    host.sequence = (uint16_t)(host.sequence + 3);
    expect_state(CRN_WIRE_STATE_RUNNING);
    assert_int_equal(status.sequence_gaps, 1);
}

static void unknown_types_and_malformed_payloads_are_refused(void **state)
{
    (void)state;
    assert_true(client_start_session(&host));
    const uint8_t bytes[3] = {0, 0, 0};
    client_send(&host, 0x7777, bytes, sizeof bytes);
    expect_reject(CRN_REJECT_UNKNOWN_TYPE);
    client_send(&host, CRN_WIRE_TYPE_step, bytes, sizeof bytes);
    expect_reject(CRN_REJECT_MALFORMED);
    client_command(&host, 77);
    expect_reject(CRN_REJECT_ACTION_UNKNOWN);
    client_get(&host, 77);
    expect_reject(CRN_REJECT_ACTION_UNKNOWN);
    expect_state(CRN_WIRE_STATE_RUNNING);
}

/* --- states --- */

static void states_follow_the_diagram(void **state)
{
    (void)state;
    client_hello(&host, crn_wire_schema_hash());
    client_receive(&host);
    client_command(&host, CRN_WIRE_ACTION_ARM);
    expect_reject(CRN_REJECT_SET_UP_MISSING);
    client_command(&host, CRN_WIRE_ACTION_START);
    expect_reject(CRN_REJECT_WRONG_STATE);
    assert_true(client_start_session(&host));
    client_command(&host, CRN_WIRE_ACTION_ARM);
    expect_reject(CRN_REJECT_WRONG_STATE);
    client_command(&host, CRN_WIRE_ACTION_FREE_RUN);
    expect_reject(CRN_REJECT_WRONG_STATE);
    client_command(&host, CRN_WIRE_ACTION_STOP);
    assert_true(client_expect_status(&host, &status));
    assert_int_equal(status.state, CRN_WIRE_STATE_ARMED);
    client_command(&host, CRN_WIRE_ACTION_RESET);
    assert_true(client_expect_status(&host, &status));
    assert_int_equal(status.state, CRN_WIRE_STATE_READY);
}

static void set_up_messages_are_refused_while_running(void **state)
{
    (void)state;
    const uint8_t scene_begin[8] = {16};
    assert_true(client_start_session(&host));
    client_plain_tools(&tools, 1);
    client_tools(&host, &tools);
    expect_reject(CRN_REJECT_WRONG_STATE);
    client_entry(&host, 0);
    expect_reject(CRN_REJECT_WRONG_STATE);
    client_send(&host, CRN_WIRE_TYPE_scene_begin, scene_begin, sizeof scene_begin);
    expect_reject(CRN_REJECT_WRONG_STATE);
}

static void more_inserted_than_there_is_does_not_arm(void **state)
{
    (void)state;
    assert_true(client_start_session(&host));
    client_command(&host, CRN_WIRE_ACTION_RESET);
    assert_true(client_expect_status(&host, &status));
    client_entry(&host, 300001);
    assert_true(client_expect_status(&host, &status));
    client_command(&host, CRN_WIRE_ACTION_ARM);
    expect_reject(CRN_REJECT_LENGTH_INSERTED);
    assert_int_equal(reject.detail1, 0);
    assert_int_equal(reject.detail2, 300000);
    expect_state(CRN_WIRE_STATE_READY);
}

/* --- scene --- */

static void scene_begin(uint32_t bytes, uint32_t crc)
{
    uint8_t payload[8];
    crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
    const crn_wire_scene_begin begin = {bytes, crc};
    crn_wire_put_scene_begin(&writer, &begin);
    client_send(&host, CRN_WIRE_TYPE_scene_begin, payload, writer.length);
}

static void scene_chunk(uint32_t offset, uint16_t count)
{
    static crn_wire_scene_chunk chunk;
    static uint8_t payload[CRN_WIRE_PAYLOAD_MAX];
    crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
    chunk.offset = offset;
    chunk.data_count = count;
    crn_wire_put_scene_chunk(&writer, &chunk);
    client_send(&host, CRN_WIRE_TYPE_scene_chunk, payload, writer.length);
}

static void scene_end(uint32_t bytes)
{
    uint8_t payload[4];
    crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
    crn_wire_write(&writer, bytes, 4);
    client_send(&host, CRN_WIRE_TYPE_scene_end, payload, 4);
}

static void scenes_that_are_oversized_disordered_or_damaged_are_refused(void **state)
{
    (void)state;
    client_hello(&host, crn_wire_schema_hash());
    client_receive(&host);
    scene_begin((1 << 20) + 1, 0);
    expect_reject(CRN_REJECT_SCENE_SIZE);
    scene_chunk(0, 4);
    expect_reject(CRN_REJECT_SCENE_ORDER);
    scene_begin(64, 0x12345678);
    assert_true(client_expect_status(&host, &status));
    scene_chunk(4, 4);
    expect_reject(CRN_REJECT_SCENE_ORDER);
    scene_chunk(0, 65);
    expect_reject(CRN_REJECT_SCENE_ORDER);
    scene_chunk(0, 64);
    scene_end(64);
    expect_reject(CRN_REJECT_SCENE_CRC);
    const uint8_t zeros[64] = {0};
    scene_begin(64, crn_wire_crc32(0, zeros, 64));
    assert_true(client_expect_status(&host, &status));
    scene_chunk(0, 64);
    scene_end(64);
    expect_reject(CRN_REJECT_SCENE_INVALID);
}

/* --- LOCKSTEP --- */

static void a_step_at_another_tick_is_refused_and_changes_nothing(void **state)
{
    (void)state;
    assert_true(client_start_session(&host));
    client_step(&host, 0, 10, 0, 5);
    assert_true(client_expect_ticks(&host, &ticks));
    assert_int_equal(ticks.states_count, 10);
    assert_int_equal(ticks.states[9].tick, 10);
    client_step(&host, 9, 1, 50, 0);
    expect_reject(CRN_REJECT_WRONG_TICK);
    assert_int_equal(reject.detail1, 10);
    expect_state(CRN_WIRE_STATE_RUNNING);
    assert_int_equal(status.tick, 10);
}

/* The hand moves 20 um per tick for 1000 ticks, which is 20 mm in total; the first reading of the encoder
 * only sets the zero position. The tool's position has a tolerance of 0.1 mm, because the tool's inertia
 * makes the coupling between hand and tool yield. */
static void the_instrument_follows_the_encoder(void **state)
{
    (void)state;
    assert_true(client_start_session(&host));
    for (uint32_t tick = 0; tick < 1000; tick += 50) {
        client_step(&host, tick, 50, 777 + 20 * (int32_t)tick, 20);
        assert_true(client_expect_ticks(&host, &ticks));
    }
    double inserted_mm = ticks.states[49].tools[0].inserted_m_q30 / 1073741824.0 * 1e3;
    double expected_mm = 50.0 + 999 * 0.020;
    if (inserted_mm < expected_mm - 0.1 || inserted_mm > expected_mm + 0.1) {
        fail_msg("inserted = %.3f mm, expected %.3f +- 0.1", inserted_mm, expected_mm);
    }
}

/* If the encoder's counter starts at any other value and wraps during the motion, the same motion of the hand
 * gives the same hashes. */
static void counters_may_wrap(void **state)
{
    (void)state;
    uint32_t lanes[2][2];
    for (int run = 0; run < 2; run++) {
        client_close(&host);
        client_open(&host, 1 << 20);
        assert_true(client_start_session(&host));
        client_step(&host, 0, 60, run == 0 ? 0 : INT32_MAX - 30 * 20, 20);
        assert_true(client_expect_ticks(&host, &ticks));
        lanes[run][0] = ticks.states[59].hash_lane0;
        lanes[run][1] = ticks.states[59].hash_lane1;
    }
    assert_memory_equal(lanes[0], lanes[1], sizeof lanes[0]);
}

/* A change of the hand's position by 5 mm in a tick, at 1 um per count, is the largest that the device
 * accepts as plausible. */
static void an_encoder_jump_stops_the_session(void **state)
{
    (void)state;
    assert_true(client_start_session(&host));
    client_step(&host, 0, 2, 0, 5000);
    assert_true(client_expect_ticks(&host, &ticks));
    assert_int_equal(ticks.states_count, 2);
    client_step(&host, 2, 3, 10001, 0);
    assert_true(client_expect_ticks(&host, &ticks));
    assert_int_equal(ticks.states_count, 0);
    expect_state(CRN_WIRE_STATE_FAULT);
    assert_int_equal(status.fault_code, CRN_FAULT_CODE_ENCODER_JUMP_TRANSLATION);
    client_step(&host, 2, 1, 5000, 0);
    expect_reject(CRN_REJECT_WRONG_STATE);
    client_command(&host, CRN_WIRE_ACTION_RESET);
    assert_true(client_expect_status(&host, &status));
    assert_int_equal(status.state, CRN_WIRE_STATE_READY);
    assert_int_equal(status.fault_code, CRN_FAULT_CODE_NONE);
}

/* --- forces --- */

static void send_rig(uint32_t gain_milli, uint32_t limit_mN)
{
    const crn_wire_track track = {.translation_pm_per_count = 1000000,
                                  .rotation_counts_per_turn = 65536,
                                  .force_gain_milli = gain_milli,
                                  .force_limit_mN = limit_mN,
                                  .torque_limit_uN_m = 1000};
    client_rig(&host, &track, 1);
}

static void force_limits_can_be_lowered_but_not_raised(void **state)
{
    (void)state;
    client_hello(&host, crn_wire_schema_hash());
    client_receive(&host);
    send_rig(1000, 500);
    assert_true(client_expect_status(&host, &status));
    send_rig(1000, 501);
    expect_reject(CRN_REJECT_RIG_RANGE);
    assert_int_equal(reject.detail2, 3);
    send_rig(4001, 500);
    expect_reject(CRN_REJECT_RIG_RANGE);
    assert_int_equal(reject.detail2, 2);
}

/* When the hand jerks suddenly at a force gain of 4, the motor command stays within its limit and grows by at
 * most its slew limit per tick. */
static void motor_commands_stay_within_limit_and_slew(void **state)
{
    (void)state;
    client_hello(&host, crn_wire_schema_hash());
    client_receive(&host);
    send_rig(4000, 60);
    assert_true(client_expect_status(&host, &status));
    assert_true(client_start_session(&host));
    int32_t last = 0, largest = 0;
    for (uint32_t tick = 0; tick < 640; tick += 64) {
        int32_t step = (tick / 64) % 2 ? -400 : 400;
        client_step(&host, tick, 64, (tick / 64) % 2 ? 64 * 400 : 0, step);
        assert_true(client_expect_ticks(&host, &ticks));
        for (int i = 0; i < ticks.states_count; i++) {
            int32_t now = ticks.states[i].tools[0].motor_axial_mN;
            assert_true(abs(now) <= 60 && now <= (last > 0 ? last : 0) + 50 &&
                        now >= (last < 0 ? last : 0) - 50);
            if (abs(now) > largest) largest = abs(now);
            last = now;
        }
    }
    assert_true(largest > 0);
    assert_int_equal(crn_sim_read_motors(host.sim).drive, 0); /* LOCKSTEP keeps the motors off */
}

/* --- FREE_RUN --- */

static bool start_coupled(void)
{
    const crn_wire_track track = client_plain_track();
    client_hello(&host, crn_wire_schema_hash());
    client_receive(&host);
    client_rig(&host, &track, 1);
    return client_expect_status(&host, &status) && client_start_session(&host);
}

static bool start_free_run(void)
{
    const crn_port_inputs rig = crn_sim_healthy_inputs();
    crn_sim_set_inputs(host.sim, &rig);
    if (!start_coupled()) return false;
    client_command(&host, CRN_WIRE_ACTION_STOP);
    client_expect_status(&host, &status);
    client_command(&host, CRN_WIRE_ACTION_FREE_RUN);
    client_expect_status(&host, &status);
    crn_sim_timer(host.sim, 1);
    if (!client_arm_motors(&host)) return false;
    client_command(&host, CRN_WIRE_ACTION_START);
    return client_expect_status(&host, &status) && status.mode == CRN_WIRE_MODE_FREE_RUN;
}

static void in_free_run_the_timer_owns_the_tick(void **state)
{
    (void)state;
    assert_true(start_free_run());
    client_step(&host, 0, 1, 0, 0);
    expect_reject(CRN_REJECT_WRONG_MODE);
    crn_sim_timer(host.sim, 32);
    assert_int_equal(crn_sim_read_motors(host.sim).drive, 1);
    assert_true(client_expect_ticks(&host, &ticks));
    assert_int_equal(ticks.states_count, 16);
    assert_int_equal(host.decoder.header.answers, 0);
    assert_true(client_expect_ticks(&host, &ticks));
    assert_int_equal(ticks.states[15].tick, 32);
    client_command(&host, CRN_WIRE_ACTION_STOP);
    assert_true(client_expect_status(&host, &status));
    assert_int_equal(crn_sim_read_motors(host.sim).drive, 0);
}

static void both_modes_give_the_same_hashes(void **state)
{
    (void)state;
    assert_true(start_coupled());
    client_step(&host, 0, 64, 0, 0);
    assert_true(client_expect_ticks(&host, &ticks));
    uint32_t lanes[2] = {ticks.states[63].hash_lane0, ticks.states[63].hash_lane1};
    client_close(&host);
    client_open(&host, 0);
    assert_true(start_free_run());
    crn_sim_timer(host.sim, 64);
    for (int i = 0; i < 4; i++) assert_true(client_expect_ticks(&host, &ticks));
    assert_int_equal(ticks.states[15].hash_lane0, lanes[0]);
    assert_int_equal(ticks.states[15].hash_lane1, lanes[1]);
}

static void a_silent_host_is_logged_and_the_simulation_goes_on(void **state)
{
    (void)state;
    static crn_wire_fault_log log;
    assert_true(start_free_run());
    crn_sim_timer(host.sim, 29);
    client_get(&host, CRN_WIRE_GET_FAULT_LOG);
    while (client_receive(&host) != CRN_WIRE_TYPE_fault_log) {
    }
    assert_true(crn_wire_decode_fault_log(host.decoder.payload, host.decoder.payload_bytes, &log));
    assert_int_equal(log.entries_count, 0);
    crn_sim_timer(host.sim, 300);
    client_get(&host, CRN_WIRE_GET_FAULT_LOG);
    while (client_receive(&host) != CRN_WIRE_TYPE_fault_log) {
    }
    assert_true(crn_wire_decode_fault_log(host.decoder.payload, host.decoder.payload_bytes, &log));
    assert_int_equal(log.entries_count, 1);
    assert_int_equal(log.entries[0].code, CRN_FAULT_CODE_HOST_SILENT);
    expect_state(CRN_WIRE_STATE_RUNNING);
    assert_int_equal(status.tick, 329);
}

/* --- snapshots --- */

static void a_snapshot_continues_bit_for_bit(void **state)
{
    (void)state;
    assert_true(client_start_session(&host));
    client_step(&host, 0, 40, 0, 30);
    assert_true(client_expect_ticks(&host, &ticks));
    assert_true(client_read_snapshot(&host));
    client_step(&host, 40, 40, 40 * 30, 30);
    assert_true(client_expect_ticks(&host, &ticks));
    crn_wire_tick_state expected = ticks.states[39];
    client_command(&host, CRN_WIRE_ACTION_STOP);
    assert_true(client_expect_status(&host, &status));
    client_write_snapshot(&host);
    assert_true(client_expect_status(&host, &status));
    assert_int_equal(status.tick, 40);
    client_command(&host, CRN_WIRE_ACTION_START);
    assert_true(client_expect_status(&host, &status));
    client_step(&host, 40, 40, 40 * 30, 30);
    assert_true(client_expect_ticks(&host, &ticks));
    assert_memory_equal(&expected, &ticks.states[39], sizeof expected);
}

static void a_snapshot_is_refused_while_running(void **state)
{
    (void)state;
    assert_true(client_start_session(&host));
    assert_true(client_read_snapshot(&host));
    client_write_snapshot(&host);
    assert_int_equal(host.decoder.header.type, CRN_WIRE_TYPE_reject);
}

/* The test damages fields of the snapshot's header: it sets unknown flags, a motor force beyond its limit,
 * and a tick that differs from the core's. */
static void a_snapshot_with_impossible_contents_leaves_the_state(void **state)
{
    (void)state;
    const struct {
        size_t byte;
        uint8_t value;
    } damage[] = {
        {0, 9}, {4, 77}, {8, 2}, {12, 2}, {43, 0x7f}, {47, 0x80}, {CRN_APP_SNAPSHOT_HEAD_BYTES + 8, 0xff}};
    assert_true(client_start_session(&host));
    client_step(&host, 0, 20, 0, 30);
    assert_true(client_expect_ticks(&host, &ticks));
    assert_true(client_read_snapshot(&host));
    client_command(&host, CRN_WIRE_ACTION_STOP);
    assert_true(client_expect_status(&host, &status));
    for (size_t i = 0; i < sizeof damage / sizeof damage[0]; i++) {
        uint8_t kept = host.snapshot[damage[i].byte];
        host.snapshot[damage[i].byte] = damage[i].value;
        client_write_snapshot(&host);
        expect_reject(CRN_REJECT_SNAPSHOT_INVALID);
        host.snapshot[damage[i].byte] = kept;
    }
    client_write_snapshot(&host);
    assert_true(client_expect_status(&host, &status));
    assert_int_equal(status.tick, 20);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(nothing_is_answered_before_hello),
        TEST(another_schema_hash_is_refused_and_both_are_known),
        TEST(replies_name_the_request_they_answer),
        TEST(missing_frames_are_counted),
        TEST(unknown_types_and_malformed_payloads_are_refused),
        TEST(states_follow_the_diagram),
        TEST(set_up_messages_are_refused_while_running),
        TEST(more_inserted_than_there_is_does_not_arm),
        TEST(scenes_that_are_oversized_disordered_or_damaged_are_refused),
        TEST(a_step_at_another_tick_is_refused_and_changes_nothing),
        TEST(the_instrument_follows_the_encoder),
        TEST(counters_may_wrap),
        TEST(an_encoder_jump_stops_the_session),
        TEST(force_limits_can_be_lowered_but_not_raised),
        TEST(motor_commands_stay_within_limit_and_slew),
        TEST(in_free_run_the_timer_owns_the_tick),
        TEST(both_modes_give_the_same_hashes),
        TEST(a_silent_host_is_logged_and_the_simulation_goes_on),
        TEST(a_snapshot_continues_bit_for_bit),
        TEST(a_snapshot_is_refused_while_running),
        TEST(a_snapshot_with_impossible_contents_leaves_the_state),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
