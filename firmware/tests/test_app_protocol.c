/* These tests check the commands and the set-up messages of the wire protocol. Powering the motors needs two
 * steps that no stray frame can complete. An interrupted upload can be resumed, the device reports settings
 * as the host has set them, and a refused message changes nothing. The tests exchange bytes with the device
 * on the simulated port only. */
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
static crn_wire_reject reject;

static void expect_reject(uint16_t code)
{
    assert_true(client_expect_reject(host, &reject));
    if (reject.code != code) {
        fail_msg("refused with %s, expected %s", crn_wire_reject_name(reject.code),
                 crn_wire_reject_name(code));
    }
}

static void refuse(uint8_t action, uint16_t code)
{
    bench_drain(&b);
    client_command(host, action);
    expect_reject(code);
}

#define TAKE(name, value)                                                                                    \
    do {                                                                                                     \
        assert_int_equal(client_receive(host), CRN_WIRE_TYPE_##name);                                        \
        assert_true(crn_wire_decode_##name(host->decoder.payload, host->decoder.payload_bytes, value));      \
    } while (0)

/* --- two steps --- */

/* Requirement: SR-08 */
static void motors_need_both_steps_in_their_order_and_time(void **state)
{
    (void)state;
    refuse(CRN_WIRE_ACTION_ARM_MOTORS, CRN_REJECT_WRONG_STATE);
    command(CRN_WIRE_ACTION_ARM);
    refuse(CRN_WIRE_ACTION_START, CRN_REJECT_NOT_CONFIRMED);
    client_confirm(host, 0);
    expect_reject(CRN_REJECT_CODE_WRONG);
    command(CRN_WIRE_ACTION_ARM_MOTORS);
    const uint32_t first = status.arm_code;
    assert_true(first != 0);
    refuse(CRN_WIRE_ACTION_START, CRN_REJECT_NOT_CONFIRMED);
    client_confirm(host, first ^ 1);
    expect_reject(CRN_REJECT_CODE_WRONG);
    client_confirm(host, first); /* used up by the wrong answer */
    expect_reject(CRN_REJECT_CODE_WRONG);
    command(CRN_WIRE_ACTION_ARM_MOTORS);
    assert_true(status.arm_code != first);
    const uint32_t second = status.arm_code;
    for (int i = 0; i < CRN_APP_CODE_ticks + 1; i++) bench_tick(&b);
    bench_drain(&b);
    client_confirm(host, second); /* too late */
    expect_reject(CRN_REJECT_CODE_WRONG);
    assert_int_equal(crn_sim_read_motors(host->sim).drive, 0);
    assert_true(client_arm_motors(host));
    command(CRN_WIRE_ACTION_START);
    bench_tick(&b);
    assert_int_equal(crn_sim_read_motors(host->sim).drive, 1);
}

/* A permission to power the motors is valid for one START; after STOP, RESET, a change of mode or a fault,
 * the two steps are required again. */
static void a_permission_is_good_for_one_start(void **state)
{
    (void)state;
    assert_true(bench_power(&b));
    command(CRN_WIRE_ACTION_STOP);
    assert_int_equal(status.motors_armed, 0);
    refuse(CRN_WIRE_ACTION_START, CRN_REJECT_NOT_CONFIRMED);
    assert_true(client_arm_motors(host));
    command(CRN_WIRE_ACTION_LOCKSTEP);
    command(CRN_WIRE_ACTION_FREE_RUN);
    refuse(CRN_WIRE_ACTION_START, CRN_REJECT_NOT_CONFIRMED);
    assert_true(client_arm_motors(host));
    command(CRN_WIRE_ACTION_RESET);
    command(CRN_WIRE_ACTION_ARM);
    refuse(CRN_WIRE_ACTION_START, CRN_REJECT_NOT_CONFIRMED);
}

/* A person has confirmed the power of the motors but has not pressed START. Such a confirmation is valid
 * neither for a host that comes an hour later nor for a host that sends HELLO now. */
static void a_permission_is_not_left_lying_about(void **state)
{
    (void)state;
    command(CRN_WIRE_ACTION_ARM);
    assert_true(client_arm_motors(host));
    for (int i = 0; i < CRN_APP_CODE_ticks; i++) bench_tick(&b);
    assert_int_equal(bench_status(&b).motors_armed, 1);
    bench_tick(&b);
    assert_int_equal(bench_status(&b).motors_armed, 0);
    refuse(CRN_WIRE_ACTION_START, CRN_REJECT_NOT_CONFIRMED);
    assert_true(client_arm_motors(host));
    client_hello(host, crn_wire_schema_hash());
    bench_drain(&b);
    refuse(CRN_WIRE_ACTION_START, CRN_REJECT_NOT_CONFIRMED);
    command(CRN_WIRE_ACTION_ARM_MOTORS);
    const uint32_t code = status.arm_code;
    client_hello(host, crn_wire_schema_hash());
    bench_drain(&b);
    client_confirm(host, code);
    expect_reject(CRN_REJECT_CODE_WRONG);
}

/* The test takes the frames of a conversation that powers the motors, and sends each single frame twice to an
 * armed device. No single frame powers a motor. */
/* Requirement: SR-08 */
static void no_single_frame_powers_a_motor(void **state)
{
    (void)state;
    command(CRN_WIRE_ACTION_ARM);
    for (uint32_t action = 0; action < 256; action++) {
        for (int twice = 0; twice < 2; twice++) {
            bench_drain(&b);
            client_command(host, (uint8_t)action);
            bench_tick(&b);
            assert_int_equal(crn_sim_read_motors(host->sim).drive, 0);
        }
        if (bench_status(&b).state == CRN_WIRE_STATE_READY) command(CRN_WIRE_ACTION_ARM);
        if (bench_status(&b).mode == CRN_WIRE_MODE_LOCKSTEP) {
            if (status.state == CRN_WIRE_STATE_RUNNING) command(CRN_WIRE_ACTION_STOP);
            bench_drain(&b);
            client_command(host, CRN_WIRE_ACTION_FREE_RUN);
        }
    }
}

static void an_unsafe_rig_is_not_armed_and_the_cause_is_named(void **state)
{
    (void)state;
    const crn_port_inputs healthy = crn_sim_healthy_inputs();
    command(CRN_WIRE_ACTION_ARM);
    for (int i = 0; i < 6; i++) {
        b.rig = healthy;
        if (i == 0) b.rig.emergency_stop = true;
        if (i == 1) b.rig.supply_good = false;
        if (i == 2) b.rig.tracks[0].translation_sensor = CRN_PORT_SENSOR_ERROR;
        if (i == 3) b.rig.tracks[0].force_sensor = CRN_PORT_SENSOR_RANGE;
        if (i == 4) b.rig.tracks[0].over_current = true;
        if (i == 5) b.rig.tracks[0].force_raw = 1001;
        static const uint16_t causes[] = {CRN_FAULT_CODE_EMERGENCY_STOP, CRN_FAULT_CODE_SUPPLY_LOST,
                                          CRN_FAULT_CODE_ENCODER_LOST,   CRN_FAULT_CODE_FORCE_SENSOR_LOST,
                                          CRN_FAULT_CODE_OVER_CURRENT,   CRN_FAULT_CODE_ACTUATOR_STUCK_ON};
        bench_tick(&b);
        refuse(CRN_WIRE_ACTION_ARM_MOTORS, CRN_REJECT_NOT_SAFE);
        assert_int_equal(reject.detail1, causes[i]);
    }
    b.rig = healthy;
    bench_tick(&b);
    assert_true(client_arm_motors(host));
    b.rig.emergency_stop = true; /* between CONFIRM and START */
    bench_tick(&b);
    refuse(CRN_WIRE_ACTION_START, CRN_REJECT_NOT_SAFE);
    crn_sim_set_inputs(host->sim, NULL);
    crn_sim_timer(host->sim, 1);
    refuse(CRN_WIRE_ACTION_ARM_MOTORS, CRN_REJECT_NO_RIG);
}

/* Without a force sensor, the device cannot check the motors' forces. The device powers motors without a
 * force sensor only if a person at the rig closes the switch inside the rig. */
static void a_rig_without_force_sensor_is_powered_only_by_the_local_unlock(void **state)
{
    (void)state;
    command(CRN_WIRE_ACTION_ARM);
    b.rig.tracks[0].force_sensor = CRN_PORT_SENSOR_ABSENT;
    bench_tick(&b);
    refuse(CRN_WIRE_ACTION_ARM_MOTORS, CRN_REJECT_NOT_SAFE);
    assert_int_equal(reject.detail1, CRN_FAULT_CODE_FORCE_SENSOR_LOST);
    b.rig.local_unlock = true;
    bench_tick(&b);
    assert_true(client_arm_motors(host));
    b.rig.local_unlock = false; /* opened again before START */
    bench_tick(&b);
    refuse(CRN_WIRE_ACTION_START, CRN_REJECT_NOT_SAFE);
}

static void lockstep_holds_the_motors_off(void **state)
{
    (void)state;
    command(CRN_WIRE_ACTION_LOCKSTEP);
    command(CRN_WIRE_ACTION_ARM);
    refuse(CRN_WIRE_ACTION_ARM_MOTORS, CRN_REJECT_WRONG_MODE);
    command(CRN_WIRE_ACTION_START);
    for (uint32_t tick = 0; tick < 100; tick++) {
        static crn_wire_ticks ticks;
        client_step(host, tick, 1, (int32_t)tick * 900, 0);
        assert_true(client_expect_ticks(host, &ticks));
        crn_sim_timer(host->sim, 1);
        assert_int_equal(crn_sim_read_motors(host->sim).drive, 0);
        assert_false(crn_sim_read_outputs(host->sim).enable);
    }
}

/* --- set-up --- */

static crn_wire_set_up read_set_up(void)
{
    crn_wire_set_up set_up;
    bench_drain(&b);
    client_get(host, CRN_WIRE_GET_SET_UP);
    TAKE(set_up, &set_up);
    return set_up;
}

static void send_chunk(const uint8_t *bytes, uint32_t offset, uint16_t count)
{
    static crn_wire_scene_chunk chunk;
    static uint8_t payload[CRN_WIRE_BYTES_scene_chunk];
    chunk.offset = offset;
    chunk.data_count = count;
    memcpy(chunk.data, bytes + offset, count);
    crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
    assert_true(crn_wire_put_scene_chunk(&writer, &chunk));
    client_send(host, CRN_WIRE_TYPE_scene_chunk, payload, writer.length);
}

static void begin_upload(uint32_t bytes, uint32_t crc32)
{
    uint8_t payload[CRN_WIRE_BYTES_scene_begin];
    const crn_wire_scene_begin begin = {bytes, crc32};
    crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
    crn_wire_put_scene_begin(&writer, &begin);
    client_send(host, CRN_WIRE_TYPE_scene_begin, payload, writer.length);
    assert_true(client_expect_status(host, &status));
}

/* The upload is interrupted after 1,000 of 3,000 bytes. The host reconnects, requests the number of received
 * bytes, and sends the remaining bytes. The CRC over all bytes of an upload decides at the end whether the
 * upload is accepted. In this test the check of the scene itself fails on purpose, after the CRC was found
 * correct. */
static void an_upload_that_was_cut_goes_on_where_it_stopped(void **state)
{
    (void)state;
    static uint8_t scene[3000];
    for (size_t i = 0; i < sizeof scene; i++) scene[i] = (uint8_t)(i * 7);
    const uint32_t crc = crn_wire_crc32(0, scene, sizeof scene);
    bench_drain(&b);
    begin_upload(sizeof scene, crc);
    send_chunk(scene, 0, 1000);
    client_hello(host, crn_wire_schema_hash()); /* the host has returned */
    bench_drain(&b);
    crn_wire_set_up there = read_set_up();
    assert_int_equal(there.upload_bytes, sizeof scene);
    assert_int_equal(there.upload_crc32, crc);
    assert_int_equal(there.upload_received, 1000);
    begin_upload(sizeof scene, crc);
    assert_int_equal(read_set_up().upload_received, 1000);
    send_chunk(scene, 1000, 2000);
    const uint8_t end[4] = {sizeof scene & 255, sizeof scene >> 8};
    client_send(host, CRN_WIRE_TYPE_scene_end, end, sizeof end);
    expect_reject(CRN_REJECT_SCENE_INVALID);
    assert_int_equal(read_set_up().upload_bytes, 0);
    begin_upload(sizeof scene, crc);
    send_chunk(scene, 0, 1000);
    begin_upload(sizeof scene, crc ^ 1); /* another scene starts from the beginning */
    assert_int_equal(read_set_up().upload_received, 0);
}

static void what_was_set_up_is_known_by_its_crc(void **state)
{
    (void)state;
    static crn_wire_tools tools;
    static uint8_t payload[CRN_WIRE_BYTES_tools];
    client_plain_tools(&tools, 1);
    crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
    crn_wire_put_tools(&writer, &tools);
    crn_wire_set_up there = read_set_up();
    assert_int_equal(there.tool_count, 1);
    assert_int_equal(there.tools_crc32, crn_wire_crc32(0, payload, writer.length));
    assert_int_equal(there.has_entry, 1);
    assert_int_equal(there.scene_bytes, 0);
}

static void the_rig_is_read_back_as_it_is_in_force(void **state)
{
    (void)state;
    crn_wire_rig rig;
    crn_wire_track track = client_plain_track();
    track.force_limit_mN = 700;
    track.force_slew_mN_per_tick = 7;
    track.force_zero_counts = -12;
    track.force_uN_per_count = 800;
    track.seal_mN = 30;
    bench_drain(&b);
    client_rig(host, &track, 1);
    assert_true(client_expect_status(host, &status));
    client_get(host, CRN_WIRE_GET_RIG);
    TAKE(rig, &rig);
    track.torque_slew_uN_m_per_tick = CRN_APP_TORQUE_SLEW_uN_m_per_tick; /* 0 kept it */
    assert_int_equal(rig.tracks_count, CRN_WIRE_TOOL_MAX);
    assert_memory_equal(&rig.tracks[0], &track, sizeof track);
    assert_int_equal(rig.tracks[2].force_limit_mN, CRN_APP_FORCE_LIMIT_mN);
}

/* The test puts one field of the message at a time out of its range. The device must refuse a message with a
 * field out of range, name the field's number, and change nothing. */
/* Requirement: SR-19 */
static void a_rig_that_cannot_be_is_refused_by_field(void **state)
{
    (void)state;
    crn_wire_rig before, after;
    for (uint32_t i = 0; i < 12; i++) {
        static const uint32_t fields[] = {0, 1, 2, 3, 4, 5, 6, 7, 9, 15, 16, 17};
        crn_wire_track track = client_plain_track();
        uint32_t *const places[] = {&track.translation_pm_per_count,  &track.rotation_counts_per_turn,
                                    &track.force_gain_milli,          &track.force_limit_mN,
                                    &track.torque_limit_uN_m,         &track.force_slew_mN_per_tick,
                                    &track.torque_slew_uN_m_per_tick, &track.options,
                                    &track.force_uN_per_count,        &track.coupling_N_per_m,
                                    &track.coupling_uN_m_per_rad,     &track.seal_mN};
        static const uint32_t values[] = {999, 15, 4001, 8001, 20001, 51, 126, 4, 1251, 1601, 3201, 2001};
        bench_drain(&b);
        client_get(host, CRN_WIRE_GET_RIG);
        TAKE(rig, &before);
        *places[i] = values[i];
        client_rig(host, &track, 1);
        expect_reject(CRN_REJECT_RIG_RANGE);
        assert_int_equal(reject.detail2, fields[i]);
        client_get(host, CRN_WIRE_GET_RIG);
        TAKE(rig, &after);
        assert_memory_equal(before.tracks, after.tracks, sizeof before.tracks);
        *places[i] = i < 2 || i == 7 ? *places[i] : values[i] - 1;
    }
}

/* The condition for a coupling is b > K (T / 2 + t) + B. With a rig damping b of 1 N s/m, a coupling damping
 * B of 0.2 N s/m and no lag t, a stiffness K of 1,600 N/m is allowed, but not 1,601 N/m. */
/* Requirement: SR-07 */
static void a_coupling_stiffer_than_the_rig_can_render_is_refused(void **state)
{
    (void)state;
    crn_wire_track track = client_plain_track();
    track.coupling_N_per_m = 1600;
    client_rig(host, &track, 1);
    bench_drain(&b);
    track.coupling_mN_s_per_m = 201;
    client_rig(host, &track, 1);
    expect_reject(CRN_REJECT_RIG_RANGE);
}

/* A host that gives a thousandth of the true force per count of a sensor would defeat every check of forces.
 * The force sensors of the test bench have 1 mN per count, and a host may always send the value that is set
 * at present. */
/* Requirement: SR-18 */
static void the_force_sensors_scale_moves_by_a_quarter_without_the_local_unlock(void **state)
{
    (void)state;
    static const struct {
        uint32_t uN_per_count;
        bool unlocked, taken;
    } asks[] = {{1, false, false},    {749, false, false},  {750, false, true},  {1250, false, true},
                {1251, false, false}, {4000, true, true},   {4000, false, true}, {3999, false, false},
                {1000, false, true},  {4000, false, false}, {1, true, true},     {1000001, true, false}};
    crn_wire_track track = client_plain_track();
    for (size_t i = 0; i < sizeof asks / sizeof *asks; i++) {
        b.rig.local_unlock = asks[i].unlocked;
        bench_tick(&b);
        bench_drain(&b);
        track.force_uN_per_count = asks[i].uN_per_count;
        client_rig(host, &track, 1);
        if (asks[i].taken) {
            assert_true(client_expect_status(host, &status));
        } else {
            expect_reject(CRN_REJECT_RIG_RANGE);
            assert_int_equal(reject.detail2, 9);
        }
    }
}

/* Requirement: SR-18 */
static void limits_rise_only_with_the_local_unlock(void **state)
{
    (void)state;
    crn_wire_track track = client_plain_track();
    bench_drain(&b);
    track.force_limit_mN = 500;
    client_rig(host, &track, 1);
    assert_true(client_expect_status(host, &status));
    track.force_limit_mN = 501;
    client_rig(host, &track, 1);
    expect_reject(CRN_REJECT_RIG_RANGE);
    b.rig.local_unlock = true;
    bench_tick(&b);
    bench_drain(&b);
    track.force_limit_mN = 8001; /* even the unlock allows nothing beyond the built-in limit */
    client_rig(host, &track, 1);
    expect_reject(CRN_REJECT_RIG_RANGE);
    track.force_limit_mN = 8000;
    client_rig(host, &track, 1);
    assert_true(client_expect_status(host, &status));
    b.rig.local_unlock = false;
    bench_tick(&b);
    bench_drain(&b);
    track.force_limit_mN = 501;
    client_rig(host, &track, 1);
    assert_true(client_expect_status(host, &status));
    track.force_limit_mN = 502;
    client_rig(host, &track, 1);
    expect_reject(CRN_REJECT_RIG_RANGE);
}

static void the_sensors_are_read_as_they_are(void **state)
{
    (void)state;
    crn_wire_sensors sensors;
    b.rig.hands[1].rotation_counts = -77;
    b.rig.tracks[2].force_raw = 123;
    b.rig.inflator_raw = 4567;
    b.rig.syringe_counts = -3;
    b.rig.buttons = 5;
    bench_tick(&b);
    bench_drain(&b);
    client_get(host, CRN_WIRE_GET_SENSORS);
    TAKE(sensors, &sensors);
    assert_int_equal(sensors.has_rig, 1);
    assert_int_equal(sensors.tracks[1].rotation_counts, -77);
    assert_int_equal(sensors.tracks[2].force_mN, 123);
    assert_int_equal(sensors.inflator_raw, 4567);
    assert_int_equal(sensors.syringe_counts, -3);
    assert_int_equal(sensors.buttons, 5);
    assert_int_equal(sensors.lines, CRN_WIRE_LINE_SUPPLY);
}

/* The simulated device gives no access to its app, so this test creates an app of its own; the messages of
 * this app are discarded. */
static crn_app alone;
static uint32_t frames_sent;

static bool count_frame(void *context, const uint8_t *frame, size_t frame_bytes)
{
    (void)context;
    frames_sent += frame_bytes > 0 && frame[frame_bytes - 1] == 0;
    return true;
}

static size_t much_room(void *context)
{
    (void)context;
    return 1 << 20;
}

static void no_outputs(void *context, const crn_port_outputs *outputs)
{
    (void)context;
    (void)outputs;
}

static void hear(uint16_t sequence, uint16_t type, size_t payload_bytes, const uint8_t *payload)
{
    static uint8_t frame[256];
    const crn_wire_header header = {sequence, 0, type};
    size_t bytes = crn_wire_frame_encode(&header, payload, payload_bytes, frame, sizeof frame);
    crn_app_receive(&alone, frame, bytes);
}

static void hear_hello(uint16_t sequence)
{
    const crn_wire_hello hello = {CRN_WIRE_PROTOCOL_MAJOR, CRN_WIRE_PROTOCOL_MINOR, crn_wire_schema_hash()};
    uint8_t payload[CRN_WIRE_BYTES_hello];
    crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
    assert_true(crn_wire_put_hello(&writer, &hello));
    hear(sequence, CRN_WIRE_TYPE_hello, writer.length, payload);
}

/* The HID requests of this test come between the frames of the stream, and the device counts no frame as
 * missing. */
static void orders_without_a_frame_take_power_away_and_do_nothing_else(void **state)
{
    (void)state;
    const crn_port port = {
        .transmit = count_frame, .transmit_room = much_room, .outputs = no_outputs, .serial = "ALONE"};
    const uint8_t get[] = {CRN_WIRE_GET_STATUS};
    const crn_wire_rig rig = {.tracks_count = 1, .tracks = {client_plain_track()}};
    crn_app_init(&alone, &port);
    assert_false(crn_app_order(&alone, CRN_WIRE_ACTION_RESET)); /* there was no HELLO */
    crn_app_configure(&alone, &rig);
    assert_int_equal(alone.state, CRN_WIRE_STATE_INIT);
    assert_int_equal(alone.setup.tracks[0].wire.coupling_N_per_m, 0);
    assert_int_equal(frames_sent, 2); /* both refused */
    hear_hello(1);
    alone.state = CRN_WIRE_STATE_RUNNING;
    for (unsigned action = 0; action <= UINT8_MAX; action++) {
        if (action == CRN_WIRE_ACTION_STOP || action == CRN_WIRE_ACTION_RESET) continue;
        assert_false(crn_app_order(&alone, (uint8_t)action));
    }
    assert_int_equal(frames_sent, 3);
    alone.watchdog.silent_ticks = 7;
    assert_true(crn_app_order(&alone, CRN_WIRE_ACTION_STOP));
    assert_int_equal(alone.state, CRN_WIRE_STATE_ARMED);
    assert_int_equal(alone.watchdog.silent_ticks, 0); /* the host lives */
    hear(2, CRN_WIRE_TYPE_get, sizeof get, get);
    assert_true(crn_app_order(&alone, CRN_WIRE_ACTION_RESET));
    assert_int_equal(alone.state, CRN_WIRE_STATE_READY);
    crn_app_configure(&alone, &rig);
    assert_int_equal(alone.setup.tracks[0].wire.coupling_N_per_m, rig.tracks[0].coupling_N_per_m);
    hear(3, CRN_WIRE_TYPE_get, sizeof get, get);
    assert_int_equal(frames_sent, 8);
    assert_int_equal(alone.link.sequence_gaps, 0);
    for (int bad = CRN_WIRE_BAD_COBS; bad < CRN_WIRE_EVENT_COUNT; bad++)
        assert_int_equal(alone.link.decoder.event_counts[bad], 0);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(motors_need_both_steps_in_their_order_and_time),
        TEST(a_permission_is_good_for_one_start),
        TEST(a_permission_is_not_left_lying_about),
        TEST(no_single_frame_powers_a_motor),
        TEST(an_unsafe_rig_is_not_armed_and_the_cause_is_named),
        TEST(a_rig_without_force_sensor_is_powered_only_by_the_local_unlock),
        TEST(lockstep_holds_the_motors_off),
        TEST(an_upload_that_was_cut_goes_on_where_it_stopped),
        TEST(what_was_set_up_is_known_by_its_crc),
        TEST(the_rig_is_read_back_as_it_is_in_force),
        TEST(a_rig_that_cannot_be_is_refused_by_field),
        TEST(a_coupling_stiffer_than_the_rig_can_render_is_refused),
        TEST(the_force_sensors_scale_moves_by_a_quarter_without_the_local_unlock),
        TEST(limits_rise_only_with_the_local_unlock),
        TEST(the_sensors_are_read_as_they_are),
        cmocka_unit_test(orders_without_a_frame_take_power_away_and_do_nothing_else),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
