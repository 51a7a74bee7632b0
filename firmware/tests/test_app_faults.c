/* These tests check the device's reaction to every fault that can hurt a user's finger, with one test per
 * fault of shared/wire/wire_faults.def (tools/check/tests/test_faults.py compares the names). Each test
 * injects a fault at the sensors while a motor gives a force. Each test counts the edges of the timer until
 * no motor gives a force any more, measured behind the power stage. The time until the force ends is at most
 * the value in the table of faults, and the force does not return. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/app/app.h"
#include "firmware/app/app_internal.h"
#include "firmware/tests/reference/bench_fixture.h"

enum { FORCE_mN = 1500, PUSH_um = 1000 };

static crn_wire_fault_entry entry;

static void power_and_push(void)
{
    assert_true(bench_power(&b));
    assert_true(bench_push(&b, FORCE_mN));
    assert_false(bench_is_safe(&b));
}

static void expect_state(uint8_t expected)
{
    status = bench_status(&b);
    if (status.state != expected) {
        fail_msg("state %s (%s), expected %s", crn_wire_state_name(status.state),
                 crn_wire_fault_name(status.fault_code), crn_wire_state_name(expected));
    }
}

/* Neither waiting, nor START, nor a healthy rig restores the motor power; only RESET and the two messages
 * that arm the motors do. */
static void expect_latched(crn_fault_code code)
{
    const crn_port_inputs healthy = crn_sim_healthy_inputs();
    crn_wire_reject reject;
    expect_state(CRN_WIRE_STATE_FAULT);
    assert_int_equal(status.fault_code, code);
    b.rig = healthy;
    crn_sim_set_tick_us(b.host.sim, 0);
    for (int i = 0; i < 50; i++) bench_tick(&b);
    bench_drain(&b);
    client_command(&b.host, CRN_WIRE_ACTION_START);
    assert_true(client_expect_reject(&b.host, &reject));
    assert_int_equal(reject.code, CRN_REJECT_WRONG_STATE);
    bench_tick(&b);
    assert_true(bench_is_safe(&b) && crn_sim_read_motors(b.host.sim).drive == 0);
    client_command(&b.host, CRN_WIRE_ACTION_RESET);
    bench_drain(&b);
    assert_true(bench_power(&b));
    expect_state(CRN_WIRE_STATE_RUNNING);
}

static void expect_safe(crn_fault_code code)
{
    int took_ms = bench_time_to_safe(&b, code);
    int allowed_ms = (int)crn_wire_fault_safe_ms(code);
    print_message("# %s: safe after %d ms, allowed %d\n", crn_wire_fault_name(code), took_ms, allowed_ms);
    if (took_ms < 1 || took_ms > allowed_ms) {
        status = bench_status(&b);
        fail_msg("%s: safe after %d ms, allowed %d; state %s, %s", crn_wire_fault_name(code), took_ms,
                 allowed_ms, crn_wire_state_name(status.state), crn_wire_fault_name(status.fault_code));
    }
}

/* --- lines --- */

/* Requirement: SR-14 */
static void the_emergency_stop_takes_the_power(void **state)
{
    (void)state;
    power_and_push();
    b.rig.emergency_stop = true;
    expect_safe(CRN_FAULT_CODE_EMERGENCY_STOP);
    assert_false(crn_sim_read_outputs(b.host.sim).enable);
    expect_latched(CRN_FAULT_CODE_EMERGENCY_STOP);
}

static void a_lost_supply_takes_the_power(void **state)
{
    (void)state;
    power_and_push();
    b.rig.supply_good = false;
    expect_safe(CRN_FAULT_CODE_SUPPLY_LOST);
    expect_latched(CRN_FAULT_CODE_SUPPLY_LOST);
}

/* Requirement: SR-09, SR-15 */
static void a_power_stage_that_went_off_stays_off(void **state)
{
    (void)state;
    power_and_push();
    b.rig.stage_on = false;
    expect_safe(CRN_FAULT_CODE_STAGE_LOST);
    expect_latched(CRN_FAULT_CODE_STAGE_LOST);
}

static void a_power_stage_that_never_comes_on_is_a_fault_too(void **state)
{
    (void)state;
    b.rig.stage_on = false;
    client_command(&b.host, CRN_WIRE_ACTION_ARM);
    bench_drain(&b);
    assert_true(client_arm_motors(&b.host));
    client_command(&b.host, CRN_WIRE_ACTION_START);
    for (int i = 0; i < 8; i++) bench_tick(&b);
    expect_state(CRN_WIRE_STATE_RUNNING);
    bench_tick(&b);
    expect_state(CRN_WIRE_STATE_FAULT);
    assert_int_equal(status.fault_code, CRN_FAULT_CODE_STAGE_LOST);
}

static void a_power_stage_that_does_not_go_off_is_told(void **state)
{
    (void)state;
    power_and_push();
    crn_sim_weld_stage(b.host.sim, true);
    client_command(&b.host, CRN_WIRE_ACTION_STOP);
    int edges = 0;
    while (edges < 50 && bench_fault(&b, CRN_FAULT_CODE_STAGE_STUCK, NULL) == 0) {
        bench_tick(&b);
        edges++;
        for (int k = 0; k < CRN_PORT_TOOL_MAX; k++) {
            assert_int_equal(crn_sim_read_outputs(b.host.sim).motors[k].axial_mN, 0);
        }
    }
    assert_in_range(edges, 1, crn_wire_fault_safe_ms(CRN_FAULT_CODE_STAGE_STUCK));
    expect_state(CRN_WIRE_STATE_FAULT);
    crn_sim_weld_stage(b.host.sim, false);
    expect_latched(CRN_FAULT_CODE_STAGE_STUCK);
}

/* In this test the device is already in the state FAULT for another cause, and the device keeps reporting
 * that cause. The fault log still records the stuck power stage once, because a person must then switch off
 * the supply by hand. */
static void a_stage_that_does_not_go_off_in_a_fault_is_told_too(void **state)
{
    (void)state;
    power_and_push();
    crn_sim_weld_stage(b.host.sim, true);
    b.rig.tracks[0].over_current = true;
    for (uint32_t i = 0; i < 2 + crn_wire_fault_safe_ms(CRN_FAULT_CODE_STAGE_STUCK); i++) bench_tick(&b);
    expect_state(CRN_WIRE_STATE_FAULT);
    assert_int_equal(status.fault_code, CRN_FAULT_CODE_OVER_CURRENT);
    for (int i = 0; i < 20; i++) bench_tick(&b);
    assert_true(bench_fault(&b, CRN_FAULT_CODE_STAGE_STUCK, &entry) != 0);
    assert_int_equal(entry.count, 1);
}

static void a_rig_that_goes_away_takes_the_power(void **state)
{
    (void)state;
    power_and_push();
    crn_sim_set_inputs(b.host.sim, NULL);
    crn_sim_timer(b.host.sim, 1);
    assert_true(bench_is_safe(&b));
    assert_int_equal(bench_fault(&b, CRN_FAULT_CODE_RIG_LOST, NULL), 1);
    expect_latched(CRN_FAULT_CODE_RIG_LOST);
}

/* --- sensors --- */

static void a_lost_encoder_takes_the_power(void **state)
{
    (void)state;
    for (int about = 0; about < 2; about++) {
        for (int sensor = CRN_PORT_SENSOR_ABSENT; sensor <= CRN_PORT_SENSOR_ERROR; sensor++) {
            power_and_push();
            *(about ? &b.rig.tracks[0].rotation_sensor : &b.rig.tracks[0].translation_sensor) =
                (uint8_t)sensor;
            expect_safe(CRN_FAULT_CODE_ENCODER_LOST);
            assert_true(bench_fault(&b, CRN_FAULT_CODE_ENCODER_LOST, &entry) > 0);
            assert_int_equal(entry.value1, 0);
            assert_int_equal(entry.value2, about);
            expect_latched(CRN_FAULT_CODE_ENCODER_LOST);
            bench_close(&b);
            assert_true(bench_open(&b));
        }
    }
}

/* Requirement: SR-12 */
static void a_jump_of_the_translation_takes_the_power(void **state)
{
    (void)state;
    power_and_push();
    b.rig.hands[0].translation_counts += 5001;
    expect_safe(CRN_FAULT_CODE_ENCODER_JUMP_TRANSLATION);
    expect_latched(CRN_FAULT_CODE_ENCODER_JUMP_TRANSLATION);
}

/* Requirement: SR-12 */
static void a_jump_of_the_rotation_takes_the_power(void **state)
{
    (void)state;
    power_and_push();
    b.rig.hands[0].rotation_counts -= 65536 / 4 + 1;
    expect_safe(CRN_FAULT_CODE_ENCODER_JUMP_ROTATION);
    expect_latched(CRN_FAULT_CODE_ENCODER_JUMP_ROTATION);
}

static void a_lost_force_sensor_takes_the_power(void **state)
{
    (void)state;
    const struct {
        uint8_t sensor;
        int32_t raw;
    } losses[] = {
        {CRN_PORT_SENSOR_ABSENT, 0}, {CRN_PORT_SENSOR_RANGE, 0}, {CRN_PORT_SENSOR_ERROR, 0}, {0, 60000}};
    for (size_t i = 0; i < sizeof losses / sizeof losses[0]; i++) {
        power_and_push();
        b.rig.tracks[0].force_sensor = losses[i].sensor;
        b.rig.tracks[0].force_raw = losses[i].raw;
        expect_safe(CRN_FAULT_CODE_FORCE_SENSOR_LOST);
        expect_latched(CRN_FAULT_CODE_FORCE_SENSOR_LOST);
        bench_close(&b);
        assert_true(bench_open(&b));
    }
}

/* The measured force has the same direction as the encoder's motion, so the motor causes the part of the
 * force that was not commanded. */
static void a_force_that_was_not_asked_takes_the_power(void **state)
{
    (void)state;
    power_and_push();
    for (int edges = 1; edges <= 4; edges++) {
        b.rig.tracks[0].force_raw = edges % 2 ? 2200 : 2100;
        b.rig.hands[0].translation_counts += 800 * edges;
        bench_tick(&b);
        if (bench_is_safe(&b)) break;
    }
    assert_true(bench_is_safe(&b));
    assert_int_equal(bench_fault(&b, CRN_FAULT_CODE_FORCE_MISMATCH, NULL), 1);
    expect_latched(CRN_FAULT_CODE_FORCE_MISMATCH);
}

/* In each of the states READY, ARMED and RUNNING, the test makes the force sensor show a force while no motor
 * force is commanded. */
static void a_force_while_none_is_asked_takes_the_power(void **state)
{
    (void)state;
    for (int where = 0; where < 3; where++) {
        if (where == 1) client_command(&b.host, CRN_WIRE_ACTION_ARM);
        if (where == 2) assert_true(bench_power(&b));
        for (int i = 0; i < 30; i++) bench_tick(&b);
        b.rig.tracks[0].force_raw = 1400;
        int edges = 0;
        while (edges < 20 && bench_fault(&b, CRN_FAULT_CODE_ACTUATOR_STUCK_ON, NULL) == 0) {
            bench_tick(&b);
            edges++;
        }
        assert_in_range(edges, 1, crn_wire_fault_safe_ms(CRN_FAULT_CODE_ACTUATOR_STUCK_ON));
        assert_int_equal(crn_sim_read_motors(b.host.sim).drive, 0);
        expect_latched(CRN_FAULT_CODE_ACTUATOR_STUCK_ON);
        bench_close(&b);
        assert_true(bench_open(&b));
    }
}

/* The track's force limit is 1 N. The sensor reads the motor's 0.9 N plus 0.45 N, about 1.4 N. */
/* Requirement: SR-10 */
static void a_force_beyond_the_limit_takes_the_power(void **state)
{
    (void)state;
    crn_wire_track track = client_plain_track();
    track.force_limit_mN = 1000;
    bench_drain(&b);
    client_rig(&b.host, &track, 1);
    assert_true(client_expect_status(&b.host, &status));
    assert_true(bench_power(&b));
    assert_true(bench_push(&b, 900));
    b.rig.tracks[0].force_raw = 450;
    expect_safe(CRN_FAULT_CODE_FORCE_OVER);
    expect_state(CRN_WIRE_STATE_FAULT);
}

static void an_over_current_takes_the_power(void **state)
{
    (void)state;
    power_and_push();
    b.rig.tracks[0].over_current = true;
    expect_safe(CRN_FAULT_CODE_OVER_CURRENT);
    expect_latched(CRN_FAULT_CODE_OVER_CURRENT);
}

static void one_spike_of_over_current_is_no_fault(void **state)
{
    (void)state;
    power_and_push();
    b.rig.tracks[0].over_current = true;
    bench_tick(&b);
    b.rig.tracks[0].over_current = false;
    for (int i = 0; i < 20; i++) bench_tick(&b);
    expect_state(CRN_WIRE_STATE_RUNNING);
}

/* The hand releases the handle, so nothing opposes the motor's force of 1.5 N, and the carriage of 0.1 kg
 * accelerates. */
static int released_ms;
static void release(int encoder_sign)
{
    double speed_um = 0, way_um = 0;
    assert_true(bench_power(&b));
    assert_true(bench_push(&b, 1000));
    for (int i = 0; i < 10; i++) bench_tick(&b); /* the hand rests */
    const int32_t begin = b.rig.hands[0].translation_counts;
    int edges = 0;
    while (edges < 8 && !bench_is_safe(&b)) {
        int32_t motor_mN = crn_sim_read_motors(b.host.sim).axial_mN[0];
        speed_um -= (motor_mN - 200) / 100.0;
        way_um += speed_um;
        b.rig.tracks[0].force_raw = -motor_mN;
        b.rig.hands[0].translation_counts = begin + encoder_sign * (int32_t)way_um;
        bench_tick(&b);
        edges++;
    }
    print_message("# the carriage went %.0f um in %d ms\n", way_um, edges);
    released_ms = edges;
}

static void a_hand_that_lets_go_is_no_fault(void **state)
{
    (void)state;
    release(1);
    expect_state(CRN_WIRE_STATE_RUNNING);
}

static void a_stuck_encoder_takes_the_power(void **state)
{
    (void)state;
    release(0);
    expect_state(CRN_WIRE_STATE_FAULT);
    assert_in_range(released_ms, 1, crn_wire_fault_safe_ms(CRN_FAULT_CODE_ENCODER_STUCK));
    expect_latched(CRN_FAULT_CODE_ENCODER_STUCK);
}

static void a_reversed_encoder_takes_the_power(void **state)
{
    (void)state;
    release(-1);
    expect_state(CRN_WIRE_STATE_FAULT);
    assert_in_range(released_ms, 1, crn_wire_fault_safe_ms(CRN_FAULT_CODE_ENCODER_REVERSED));
    expect_latched(CRN_FAULT_CODE_ENCODER_REVERSED);
}

/* --- host and clock --- */

/* Requirement: SR-16 */
static void a_silent_host_takes_the_forces_within_its_time(void **state)
{
    (void)state;
    power_and_push();
    b.host_speaks = false;
    client_get(&b.host, CRN_WIRE_GET_STATUS); /* the last word */
    int edges = 0;
    int32_t before = INT32_MAX;
    while (edges < 200 && !bench_is_safe(&b)) {
        b.rig.hands[0].translation_counts +=
            PUSH_um; /* the hand keeps pushing, so that there is a force to fade */
        bench_tick(&b);
        edges++;
        int32_t now = abs(crn_sim_read_motors(b.host.sim).axial_mN[0]);
        if (edges == CRN_APP_HOST_SILENT_ticks) assert_true(now >= FORCE_mN / 2);
        if (edges > CRN_APP_HOST_SILENT_ticks) assert_true(now <= before);
        before = now;
    }
    print_message("# HOST_SILENT: no force after %d ms\n", edges);
    enum {
        MOTOR_LAG_ms = 8
    }; /* lag of the slowest motor that docs/faults.md allows; the meter here has none */
    assert_in_range(edges, 1, crn_wire_fault_safe_ms(CRN_FAULT_CODE_HOST_SILENT) - MOTOR_LAG_ms);
    const uint32_t tick = bench_status(&b).tick;
    for (int i = 0; i < 100; i++) bench_tick(&b);
    expect_state(CRN_WIRE_STATE_RUNNING);
    assert_int_equal(status.tick, tick + 100);
    assert_true(bench_fault(&b, CRN_FAULT_CODE_HOST_SILENT, &entry) > 0);
}

static void a_tick_that_takes_too_long_is_counted_and_changes_nothing(void **state)
{
    (void)state;
    crn_wire_hash64 hashes[2];
    for (int run = 0; run < 2; run++) {
        assert_true(bench_power(&b));
        for (int i = 0; i < 300; i++) {
            b.rig.hands[0].translation_counts += 20;
            crn_sim_set_tick_us(b.host.sim, run == 1 && i % 10 == 0 ? 1400 : 300);
            bench_tick(&b);
            assert_int_equal(crn_sim_read_motors(b.host.sim).drive, 1);
        }
        status = bench_status(&b);
        assert_int_equal(status.tick_overruns, run == 1 ? 30 : 0);
        assert_int_equal(status.tick_us_max, run == 1 ? 1400 : 300);
        client_get(&b.host, CRN_WIRE_GET_HASH64);
        assert_int_equal(client_receive(&b.host), CRN_WIRE_TYPE_hash64);
        assert_true(
            crn_wire_decode_hash64(b.host.decoder.payload, b.host.decoder.payload_bytes, &hashes[run]));
        assert_int_equal(bench_fault(&b, CRN_FAULT_CODE_TICK_OVERRUN, &entry), status.tick_overruns);
        bench_close(&b);
        assert_true(bench_open(&b));
    }
    assert_int_equal(hashes[0].tick, hashes[1].tick);
    assert_true(hashes[0].hash == hashes[1].hash);
}

static void a_device_that_cannot_keep_up_takes_the_power(void **state)
{
    (void)state;
    power_and_push();
    crn_sim_set_tick_us(b.host.sim, 2500);
    int took_ms = bench_time_to_safe(&b, CRN_FAULT_CODE_TICK_STALLED) * 5 / 2; /* an edge takes 2.5 ms */
    assert_in_range(took_ms, 1, crn_wire_fault_safe_ms(CRN_FAULT_CODE_TICK_STALLED));
    expect_latched(CRN_FAULT_CODE_TICK_STALLED);
}

/* The power stage removes the motor power by itself, and the firmware reports the removal as soon as it runs
 * again. */
static void a_frozen_processor_has_no_power_and_says_so_afterwards(void **state)
{
    (void)state;
    power_and_push();
    crn_sim_freeze(b.host.sim, 4);
    assert_int_equal(crn_sim_read_motors(b.host.sim).drive, 1);
    crn_sim_freeze(b.host.sim, 1);
    assert_int_equal(crn_sim_read_motors(b.host.sim).drive, 0);
    crn_sim_freeze(b.host.sim, 10000);
    bench_tick(&b);
    assert_int_equal(crn_sim_read_motors(b.host.sim).drive, 0);
    expect_latched(CRN_FAULT_CODE_TICK_STALLED);
}

/* The report is unsolicited: the host of a device that was halted learns of it like of every other end of
 * RUNNING. */
static void a_device_that_stood_still_says_so_by_itself(void **state)
{
    (void)state;
    power_and_push();
    crn_sim_freeze(b.host.sim, 100);
    bench_drain(&b);
    b.host_speaks = false;
    bench_tick(&b);
    bool is_told = false;
    for (uint16_t type = client_receive(&b.host); type != 0; type = client_receive(&b.host)) {
        if (type != CRN_WIRE_TYPE_status) continue;
        assert_true(crn_wire_decode_status(b.host.decoder.payload, b.host.decoder.payload_bytes, &status));
        is_told = status.state == CRN_WIRE_STATE_FAULT && status.request_type == 0;
    }
    assert_true(is_told);
    assert_int_equal(status.fault_code, CRN_FAULT_CODE_TICK_STALLED);
}

/* --- our own errors, and the core's --- */

static bool transmit(void *context, const uint8_t *frame, size_t bytes)
{
    (void)context;
    (void)frame;
    return bytes > 0;
}

static size_t room(void *context)
{
    (void)context;
    return SIZE_MAX;
}

static bool no_inputs(void *context, crn_port_inputs *inputs)
{
    (void)context;
    (void)inputs;
    return false;
}

static void keep_outputs(void *context, const crn_port_outputs *outputs)
{
    *(crn_port_outputs *)context = *outputs;
}

static uint32_t no_time(void *context)
{
    (void)context;
    return 0;
}

static crn_app app;
static crn_port_outputs outputs;
static const crn_port port = {.context = &outputs,
                              .transmit = transmit,
                              .transmit_room = room,
                              .inputs = no_inputs,
                              .outputs = keep_outputs,
                              .now_us = no_time,
                              .serial = "x"};

/* Requirement: SR-09 */
static void an_error_of_our_own_takes_the_power_at_once(void **state)
{
    (void)state;
    crn_app_init(&app, &port);
    assert_false(outputs.enable);
    app.state = CRN_WIRE_STATE_RUNNING;
    app.safety.is_driving = true;
    crn_app_outputs_write(&app);
    assert_true(outputs.enable);
    crn_app_internal_error(&app, 123, -5);
    assert_false(outputs.enable);
    assert_int_equal(outputs.lamp, CRN_PORT_LAMP_FAULT);
    assert_int_equal(app.state, CRN_WIRE_STATE_FAULT);
    assert_int_equal(app.faults.entries[0].code, CRN_FAULT_CODE_INTERNAL);
    assert_int_equal(app.faults.entries[0].value1, 123);
}

static void every_fault_of_the_core_is_logged_once(void **state)
{
    (void)state;
    const struct {
        uint32_t bit;
        crn_fault_code code;
    } faults[] = {{CRN_FAULT_SATURATED, CRN_FAULT_CODE_CORE_SATURATED},
                  {CRN_FAULT_FEED_LIMIT, CRN_FAULT_CODE_CORE_FEED_LIMIT},
                  {CRN_FAULT_STEP_CAPPED, CRN_FAULT_CODE_CORE_STEP_CAPPED},
                  {CRN_FAULT_INSERT_END, CRN_FAULT_CODE_CORE_INSERT_END},
                  {CRN_FAULT_OUTSIDE, CRN_FAULT_CODE_CORE_OUTSIDE}};
    crn_app_init(&app, &port);
    uint32_t bits = 0;
    for (uint16_t i = 0; i < sizeof faults / sizeof faults[0]; i++) {
        bits |= faults[i].bit;
        crn_app_log_core_faults(&app, bits);
        crn_app_log_core_faults(&app, bits);
        assert_int_equal(app.faults.count, i + 1);
        assert_int_equal(app.faults.entries[i].code, faults[i].code);
        assert_int_equal(app.faults.entries[i].count, 1);
    }
    assert_int_equal(app.state, CRN_WIRE_STATE_INIT);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(the_emergency_stop_takes_the_power),
        TEST(a_lost_supply_takes_the_power),
        TEST(a_power_stage_that_went_off_stays_off),
        TEST(a_power_stage_that_never_comes_on_is_a_fault_too),
        TEST(a_power_stage_that_does_not_go_off_is_told),
        TEST(a_stage_that_does_not_go_off_in_a_fault_is_told_too),
        TEST(a_rig_that_goes_away_takes_the_power),
        TEST(a_lost_encoder_takes_the_power),
        TEST(a_jump_of_the_translation_takes_the_power),
        TEST(a_jump_of_the_rotation_takes_the_power),
        TEST(a_lost_force_sensor_takes_the_power),
        TEST(a_force_that_was_not_asked_takes_the_power),
        TEST(a_force_while_none_is_asked_takes_the_power),
        TEST(a_force_beyond_the_limit_takes_the_power),
        TEST(an_over_current_takes_the_power),
        TEST(one_spike_of_over_current_is_no_fault),
        TEST(a_stuck_encoder_takes_the_power),
        TEST(a_reversed_encoder_takes_the_power),
        TEST(a_hand_that_lets_go_is_no_fault),
        TEST(a_silent_host_takes_the_forces_within_its_time),
        TEST(a_tick_that_takes_too_long_is_counted_and_changes_nothing),
        TEST(a_device_that_cannot_keep_up_takes_the_power),
        TEST(a_frozen_processor_has_no_power_and_says_so_afterwards),
        TEST(a_device_that_stood_still_says_so_by_itself),
        TEST(an_error_of_our_own_takes_the_power_at_once),
        TEST(every_fault_of_the_core_is_logged_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
