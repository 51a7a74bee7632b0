/* These tests check the virtual coupling between hand and tool (docs/haptics.md) on the simulated port. In
 * free motion the tool follows the hand without lag, and the hand feels no force. The hand feels the seal of
 * the sheath as friction, which holds the tool without chatter. If the tool is blocked, the hand feels a
 * spring. At the force limit the coupling slips; the force gain, the force limit and the slew limit act as
 * set by the host. The state of the virtual coupling is part of the snapshot. Unexplained energy removes the
 * force. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/app/safety/arithmetic.h"
#include "firmware/app/safety/limits.h"
#include "firmware/tests/reference/bench_fixture.h"

static client *const host = &b.host;
static crn_wire_ticks ticks;

static uint32_t tick_now;
static void start_lockstep(const crn_wire_track *track)
{
    bench_drain(&b);
    client_rig(host, track, 1);
    assert_true(client_expect_status(host, &status));
    command(CRN_WIRE_ACTION_LOCKSTEP);
    command(CRN_WIRE_ACTION_ARM);
    command(CRN_WIRE_ACTION_START);
    tick_now = 0;
}

/* Computes one tick in which the hand is at the translation `translation` um and the angle `rotation` x 2^-16
 * turn. Returns the state of the tool after this tick. */
static const crn_wire_tool_state *step_to(int32_t translation, int32_t rotation)
{
    uint8_t payload[64];
    static crn_wire_step step;
    step = (crn_wire_step){.tick = tick_now++, .inputs_count = 1};
    step.inputs[0] = (crn_wire_tick_input){.hands_count = 1, .hands = {{translation, rotation}}};
    crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
    assert_true(crn_wire_put_step(&writer, &step));
    client_send(host, CRN_WIRE_TYPE_step, payload, writer.length);
    assert_true(client_expect_ticks(host, &ticks));
    assert_int_equal(ticks.states_count, 1);
    return &ticks.states[0].tools[0];
}

static double inserted_um(const crn_wire_tool_state *tool)
{
    return tool->inserted_m_q30 / 1073741824.0 * 1e6;
}

/* At 0.1 m/s through free space the tool lags behind the hand by the few um that the wire's own weight and
 * inertia cause. */
static void a_free_tool_follows_without_lag_or_drag(void **state)
{
    (void)state;
    const crn_wire_track track = client_plain_track();
    start_lockstep(&track);
    double begin = 50000, worst_um = 0;
    int32_t worst_mN = 0;
    for (int32_t i = 0; i < 1000; i++) {
        const int32_t hand = i < 500 ? 100 * i : 100 * (1000 - i);
        const crn_wire_tool_state *tool = step_to(hand, 0);
        if (i < 50) continue;
        double lag = inserted_um(tool) - begin - hand;
        if (lag < 0) lag = -lag;
        if (lag > worst_um) worst_um = lag;
        if (abs(tool->motor_axial_mN) > worst_mN) worst_mN = abs(tool->motor_axial_mN);
    }
    print_message("# at 0.1 m/s: lag up to %.0f um, force up to %d mN\n", worst_um, worst_mN);
    assert_true(worst_um < 120 && worst_mN < 120);
}

/* If only the friction of the seal acts on the tool, the hand feels this friction against its motion in both
 * directions, and the friction settles without chatter. */
static void a_seal_is_felt_as_its_friction_and_does_not_chatter(void **state)
{
    (void)state;
    crn_wire_track track = client_plain_track();
    track.seal_mN = 300;
    start_lockstep(&track);
    const crn_wire_tool_state *tool = NULL;
    for (int32_t i = 0; i < 400; i++) tool = step_to(20 * i, 0);
    print_message("# seal of 300 mN: %d mN forth", tool->motor_axial_mN);
    assert_in_range(tool->motor_axial_mN, 250, 350);
    double before = 0;
    for (int32_t i = 0; i < 300; i++) {
        tool = step_to(7980, 0);
        if (i > 200) assert_true(before == inserted_um(tool));
        before = inserted_um(tool);
    }
    for (int32_t i = 0; i < 400; i++) tool = step_to(7980 - 20 * i, 0);
    print_message(", %d mN back\n", tool->motor_axial_mN);
    assert_in_range(-tool->motor_axial_mN, 250, 350);
}

static void a_seal_resists_turning_too(void **state)
{
    (void)state;
    crn_wire_track track = client_plain_track();
    track.seal_uN_m = 400;
    start_lockstep(&track);
    const crn_wire_tool_state *tool = NULL;
    for (int32_t i = 0; i < 500; i++) tool = step_to(0, 100 * i);
    print_message("# seal of 400 uN m: %d uN m\n", tool->motor_torque_uN_m);
    assert_in_range(tool->motor_torque_uN_m, 350, 450);
}

/* In this test the seal's friction is 2 N and the coupling's stiffness is 1 N/mm, so a hand that is 1 mm
 * ahead of the tool feels a force of one newton. If the hand is 20 mm ahead of the tool, the tool slides, and
 * the hand feels only the seal's friction of 2 N. */
static void a_held_tool_is_felt_as_the_coupling_s_spring(void **state)
{
    (void)state;
    crn_wire_track track = client_plain_track();
    track.seal_mN = 2000;
    start_lockstep(&track);
    const crn_wire_tool_state *tool = NULL;
    for (int32_t i = 0; i <= 100; i++) tool = step_to(10 * i, 0);
    for (int32_t i = 0; i < 50; i++) tool = step_to(1000, 0);
    print_message("# 1 mm at 1 N/mm: %d mN\n", tool->motor_axial_mN);
    assert_in_range(tool->motor_axial_mN, 980, 1020);
    for (int32_t i = 0; i <= 1000; i++) tool = step_to(1000 + 20 * i, 0);
    assert_in_range(tool->motor_axial_mN, 1900, 2100);
}

/* When the hand pulls far out of the patient, the tool stops at its end; the hand moves on and slips at the
 * force limit of 8 N. */
static void the_hand_slips_at_the_force_limit(void **state)
{
    (void)state;
    const crn_wire_track track = client_plain_track();
    start_lockstep(&track);
    const crn_wire_tool_state *tool = NULL;
    for (int32_t i = 0; i < 1000; i++) tool = step_to(-200 * i, 0);
    const double end_um = inserted_um(tool);
    print_message("# withdrawn to %.0f um: %d mN\n", end_um, tool->motor_axial_mN);
    assert_in_range(-tool->motor_axial_mN, 7900, 8000);
    for (int32_t i = 0; i < 400; i++) tool = step_to(-199800 + 25 * i, 0);
    /* back by 10 mm: the slipped distance does not have to be travelled back */
    assert_in_range(abs(tool->motor_axial_mN), 0, 300);
    assert_true(inserted_um(tool) > end_um + 500);
}

/* The test takes a snapshot while the hand presses against the seal; the session that continues from this
 * snapshot gives the same ticks. */
static void the_coupling_is_part_of_the_snapshot(void **state)
{
    (void)state;
    static crn_wire_tick_state expected[200];
    crn_wire_track track = client_plain_track();
    track.seal_mN = 500;
    track.seal_uN_m = 100;
    start_lockstep(&track);
    for (int32_t i = 0; i < 150; i++) step_to(13 * i, 40 * i);
    assert_true(client_read_snapshot(host));
    for (int32_t i = 0; i < 200; i++) {
        step_to(13 * 149 - 9 * i, 40 * 149 + 7 * i);
        expected[i] = ticks.states[0];
    }
    assert_true(abs(expected[0].tools[0].motor_axial_mN) > 300);
    command(CRN_WIRE_ACTION_STOP);
    client_write_snapshot(host);
    assert_true(client_expect_status(host, &status));
    command(CRN_WIRE_ACTION_START);
    tick_now = status.tick;
    for (int32_t i = 0; i < 200; i++) {
        step_to(13 * 149 - 9 * i, 40 * 149 + 7 * i);
        assert_memory_equal(&expected[i], &ticks.states[0], sizeof expected[0]);
    }
}

static int32_t shake_begin(void)
{
    crn_wire_track track = client_plain_track();
    track.seal_mN = 2000;
    bench_drain(&b);
    client_rig(host, &track, 1);
    assert_true(client_expect_status(host, &status));
    assert_true(bench_power(&b));
    for (int i = 0; i < 100; i++) {
        b.rig.hands[0].translation_counts += 10;
        bench_tick(&b);
    }
    const int32_t begin_mN = crn_sim_read_motors(host->sim).axial_mN[0];
    assert_in_range(begin_mN, 900, 1100);
    return begin_mN;
}

static void shake(int tick)
{
    b.rig.hands[0].translation_counts += tick % 2 ? 500 : -500;
    bench_tick(&b);
}

/* If a spring is computed only once a tick, a hand that shakes by 0.5 mm from tick to tick gains energy from
 * the spring. The passivity observer detects the energy that the hand gains, removes the force and reports
 * the fault. If the hand then continues to push, it gives back the energy that it gained, and the session
 * continues. */
static void forces_that_give_energy_are_reduced(void **state)
{
    (void)state;
    crn_wire_fault_entry entry;
    const int32_t begin_mN = shake_begin();
    int32_t least_mN = begin_mN;
    int ms = 0;
    while (bench_fault(&b, CRN_FAULT_CODE_PASSIVITY, &entry) < 80 && ms < 6000) {
        shake(ms++);
        int32_t now = abs(crn_sim_read_motors(host->sim).axial_mN[0]);
        least_mN = now < least_mN ? now : least_mN;
    }
    status = bench_status(&b);
    assert_int_equal(status.state, CRN_WIRE_STATE_RUNNING);
    assert_int_equal(status.passivity_ticks, 80);
    print_message("# shaking: from %d to %d mN, %d uJ given\n", begin_mN, least_mN, -entry.value2);
    assert_in_range(-entry.value2, 9999, 21000);
    assert_true(least_mN < begin_mN / 4);
}

/* In this test the hand shakes without end. After 100 ticks in a row in which the hand gains energy, the
 * motor power is removed, because the oscillation would never end by itself. */
static void energy_that_a_track_gives_for_100_ms_takes_the_power(void **state)
{
    (void)state;
    crn_wire_fault_entry entry;
    shake_begin();
    for (int ms = 0; ms < 6000 && crn_sim_read_motors(host->sim).drive; ms++) shake(ms);
    status = bench_status(&b);
    assert_int_equal(status.state, CRN_WIRE_STATE_FAULT);
    assert_int_equal(status.fault_code, CRN_FAULT_CODE_PASSIVITY_LASTS);
    assert_in_range(status.passivity_ticks, 100, 150); /* some single ones came before */
    assert_int_equal(crn_sim_read_motors(host->sim).axial_mN[0], 0);
    assert_false(crn_sim_read_outputs(host->sim).enable);
    assert_int_equal(bench_fault(&b, CRN_FAULT_CODE_PASSIVITY_LASTS, &entry), 1);
    assert_in_range(-entry.value2, 9999, 21000);
}

static void expect_quotient(int64_t value, uint32_t divisor)
{
    int64_t got = crn_quotient(value, divisor), expected = value / (int64_t)divisor;
    if (got != expected)
        fail_msg("%lld / %u = %lld, expected %lld", (long long)value, (unsigned)divisor, (long long)got,
                 (long long)expected);
}

static void the_quotient_without_a_64_bit_division_is_that_of_c(void **state)
{
    (void)state;
    static const uint32_t divisors[] = {1, 2, 3, CRN_APP_FADE_ticks, 999, 1000, 4096, 65535};
    uint64_t mixed = 1;
    for (size_t i = 0; i < sizeof divisors / sizeof divisors[0]; i++) {
        expect_quotient(INT64_MAX, divisors[i]);
        expect_quotient(-INT64_MAX, divisors[i]);
        for (int bit = 0; bit < 63; bit++) {
            for (int64_t near = -2; near <= 2; near++) {
                expect_quotient(((int64_t)1 << bit) + near, divisors[i]);
                expect_quotient(-((int64_t)1 << bit) + near, divisors[i]);
                mixed = mixed * 6364136223846793005u + 1442695040888963407u;
                expect_quotient((int64_t)(mixed >> (1 + bit)), divisors[i]);
                expect_quotient(-(int64_t)(mixed >> (1 + bit)), divisors[i]);
                expect_quotient((int64_t)(mixed >> (1 + bit)), 1 + (uint32_t)(mixed % 65535));
            }
        }
    }
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_free_tool_follows_without_lag_or_drag),
        TEST(a_seal_is_felt_as_its_friction_and_does_not_chatter),
        TEST(a_seal_resists_turning_too),
        TEST(a_held_tool_is_felt_as_the_coupling_s_spring),
        TEST(the_hand_slips_at_the_force_limit),
        TEST(the_coupling_is_part_of_the_snapshot),
        TEST(forces_that_give_energy_are_reduced),
        TEST(energy_that_a_track_gives_for_100_ms_takes_the_power),
        cmocka_unit_test(the_quotient_without_a_64_bit_division_is_that_of_c),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
