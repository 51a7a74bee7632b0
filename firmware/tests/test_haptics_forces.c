/* These tests check the forces that the haptics request, from positions and forces alone, without a rod, a
 * scene or the wire protocol. The tests cover limits and slew limits of force and torque, the fade when the
 * host is silent, the coupling's slip, passivity, and jumps of an encoder. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "firmware/app/haptics/haptics.h"

static crn_haptics haptics;
static crn_haptics_input input;
static crn_findings found;

enum { NEWTON_Q22 = 1 << 22, MM_Q30 = 1073742 };

static void begin(uint32_t stiffness_N_per_m, uint32_t seal_mN)
{
    haptics = (crn_haptics){.passivity_ticks = 0};
    input = (crn_haptics_input){.tool_count = 1, .fade_left_ticks = CRN_APP_FADE_ticks};
    found.count = 0;
    haptics.tracks[0] = (crn_haptics_track){
        .gain_milli = 1000,
        .force_limit_mN = CRN_APP_FORCE_LIMIT_mN,
        .force_slew_mN_per_tick = CRN_APP_FORCE_SLEW_mN_per_tick,
        .torque_limit_uN_m = CRN_APP_TORQUE_LIMIT_uN_m,
        .torque_slew_uN_m_per_tick = CRN_APP_TORQUE_SLEW_uN_m_per_tick,
    };
    const crn_haptics_coupling along = {stiffness_N_per_m, 0, seal_mN}, none = {0, 0, 0};
    crn_haptics_axis_set(&haptics.tracks[0].axes[CRN_APP_ALONG], CRN_APP_ALONG, &along);
    crn_haptics_axis_set(&haptics.tracks[0].axes[CRN_APP_ABOUT], CRN_APP_ABOUT, &none);
    crn_haptics_reset(&haptics);
}

/* Computes one tick in which the tool does not move; returns the position that the coupling gives to the core
 * as the target for the tool. */
static crn_hand_position tick(void)
{
    crn_hand_position followed[CRN_PORT_TOOL_MAX];
    crn_haptics_before(&haptics, &input, followed);
    crn_haptics_after(&haptics, &input, &found);
    return followed[0];
}

static int32_t force(void)
{
    return haptics.motors[0].axial_mN;
}

/* --- limits --- */

static void force_and_torque_grow_by_their_slew_up_to_their_limits_and_fall_at_once(void **state)
{
    (void)state;
    for (int sign = -1; sign <= 1; sign += 2) {
        begin(0, 0);
        input.tools[0].axial_N_q22 = sign > 0 ? INT32_MAX : -INT32_MAX;
        input.tools[0].torque_N_m_q24 = sign > 0 ? INT32_MAX : -INT32_MAX;
        for (int32_t i = 1; i <= 200; i++) {
            (void)tick();
            assert_int_equal(force(), sign * (i < 160 ? 50 * i : 8000));
            assert_int_equal(haptics.motors[0].torque_uN_m, sign * (i < 160 ? 125 * i : 20000));
        }
        input.tools[0].axial_N_q22 = sign * NEWTON_Q22;
        input.tools[0].torque_N_m_q24 = 0;
        (void)tick();
        assert_int_equal(force(), sign * 1000);
        assert_int_equal(haptics.motors[0].torque_uN_m, 0);
    }
}

static void lower_limits_and_the_gain_hold(void **state)
{
    (void)state;
    begin(0, 0);
    haptics.tracks[0].gain_milli = 500;
    input.tools[0].axial_N_q22 = 3 * NEWTON_Q22;
    for (int i = 0; i < 100; i++) (void)tick();
    assert_int_equal(force(), 1500);
    haptics.tracks[0].force_limit_mN = 700;
    (void)tick();
    assert_int_equal(force(), 700);
}

/* --- the host's silence --- */

static void a_silent_host_takes_the_force_in_a_straight_line_within_12_ticks(void **state)
{
    (void)state;
    begin(0, 0);
    input.tools[0].axial_N_q22 = 6 * NEWTON_Q22;
    input.tools[0].torque_N_m_q24 = -(12 << 24) / 1000; /* 12 mN m */
    for (int i = 0; i < 200; i++) (void)tick();
    assert_int_equal(force(), 6000);
    assert_int_equal(haptics.motors[0].torque_uN_m, -12000);
    input.is_fading = true;
    for (uint32_t left = CRN_APP_FADE_ticks + 1; left-- > 0;) {
        input.fade_left_ticks = left;
        input.tools[0].axial_N_q22 = 9 * NEWTON_Q22; /* the tool pushes harder meanwhile */
        (void)tick();
        assert_int_equal(force(), 500 * (int32_t)left);
        assert_int_equal(haptics.motors[0].torque_uN_m, -1000 * (int32_t)left);
    }
    for (int i = 0; i < 50; i++) {
        (void)tick();
        assert_int_equal(force(), 0);
    }
    input.is_fading = false; /* heard again: the slew limit counts */
    (void)tick();
    assert_int_equal(force(), 50);
}

/* --- the coupling --- */

static void a_coupling_takes_hand_and_tool_as_they_are_and_gives_no_force(void **state)
{
    (void)state;
    begin(1000, 100);
    input.hands[0].feed_m_q30 = 50 * MM_Q30;
    input.tools[0].inserted_m_q30 = 20 * MM_Q30;
    input.tools[0].hand_offset_m_q30 = 5 * MM_Q30;
    for (int i = 0; i < 10; i++) {
        assert_int_equal(tick().feed_m_q30, 15 * MM_Q30); /* the tool stays */
        assert_int_equal(force(), 0);
    }
}

/* The tool follows the hand by at most 0.48 mm a tick. The position that the haptics give to the core is
 * ahead of the tool by four times the largest motion of the tool per tick. */
static void a_lead_of_the_hand_is_a_force_on_it_and_a_step_of_the_tool(void **state)
{
    (void)state;
    begin(1000, 100);
    (void)tick();
    input.hands[0].feed_m_q30 = 2 * MM_Q30;
    const crn_hand_position followed = tick();
    assert_int_equal(followed.feed_m_q30, 4 * 515396);
    for (int i = 0; i < 100; i++) (void)tick();
    assert_in_range(force(), 1999, 2001);
}

/* The coupling's torque is 1 000 uN m/rad times 1 rad. */
static void a_lead_about_the_line_is_a_torque(void **state)
{
    (void)state;
    const crn_haptics_coupling about = {1000, 0, 10};
    begin(0, 0);
    crn_haptics_axis_set(&haptics.tracks[0].axes[CRN_APP_ABOUT], CRN_APP_ABOUT, &about);
    (void)tick();
    input.hands[0].turn32 = 683565276;
    assert_int_equal(tick().turn32, 4 * 13600000); /* the tool's largest step */
    for (int i = 0; i < 100; i++) (void)tick();
    assert_in_range(haptics.motors[0].torque_uN_m, 999, 1001);
    assert_int_equal(force(), 0);
}

static void within_the_friction_the_tool_does_not_move(void **state)
{
    (void)state;
    begin(1000, 100);
    (void)tick();
    input.hands[0].feed_m_q30 = MM_Q30 / 11;
    assert_int_equal(tick().feed_m_q30, 0);
    input.hands[0].feed_m_q30 = MM_Q30 / 9;
    assert_true(tick().feed_m_q30 > 0);
}

/* After 8 mm the coupling's force is 8 N, its limit, and the coupling slips; when the hand then moves back,
 * the force falls at once. */
static void a_hand_slips_beyond_the_force_limit(void **state)
{
    (void)state;
    begin(1000, 100);
    (void)tick();
    for (int mm = 1; mm <= 20; mm++) {
        input.hands[0].feed_m_q30 = mm * MM_Q30;
        for (int i = 0; i < 100; i++) (void)tick();
        assert_in_range(force(), (mm < 8 ? mm : 8) * 1000 - 2, (mm < 8 ? mm : 8) * 1000 + 2);
    }
    input.hands[0].feed_m_q30 -= MM_Q30;
    (void)tick();
    assert_in_range(force(), 6998, 7002);
}

/* --- passivity --- */

/* The tool moves outwards and pushes the hand, which moves with it at the same speed, so the hand receives 2
 * mJ per tick. The haptics report a finding in every tick in which the hand has received more than 10 mJ, and
 * 32 ticks later the force is zero. */
static void a_force_that_gives_energy_is_reported_and_reduced_to_nothing(void **state)
{
    (void)state;
    begin(1000, 0);
    (void)tick();
    input.hands[0].feed_m_q30 = 2 * MM_Q30;
    for (int i = 0; i < 60; i++) (void)tick();
    assert_in_range(force(), 1999, 2001);
    const int64_t stored_pJ = haptics.energies[0].taken_pJ;
    assert_int_equal(found.count, 0);
    int given = 0, ticks = 0;
    for (; haptics.energies[0].scale_q16 > 0 && ticks < 100; ticks++) {
        input.hands[0].feed_m_q30 -= MM_Q30;
        input.tools[0].inserted_m_q30 -= MM_Q30;
        haptics.springs[0][CRN_APP_ALONG].position -= MM_Q30; /* it moved before the tick */
        found.count = 0;
        (void)tick();
        if (found.count > 0) given++;
        if (haptics.energies[0].taken_pJ > -10000000000) assert_int_equal(found.count, 0);
    }
    assert_true(stored_pJ < 5000000000);
    assert_in_range(given, 32, 33);
    assert_in_range(ticks, given + 4, given + 8);
    assert_int_equal(found.list[0].code, CRN_FAULT_CODE_PASSIVITY);
    assert_int_equal(found.list[0].value1, 0);
    assert_true(found.list[0].value2 <= -10000);
    assert_int_equal(force(), 0);
    assert_int_equal(haptics.passivity_ticks, given);
}

/* --- encoders --- */

static crn_hands hands;
static crn_port_hand now[CRN_PORT_TOOL_MAX];

static void begin_hands(void)
{
    found.count = 0;
    for (int k = 0; k < CRN_PORT_TOOL_MAX; k++) {
        hands.tracks[k] = (crn_hand_track){
            .translation_m_q46_per_count = 70368744,        /* 1 um */
            .rotation_turn48_per_count = (uint64_t)1 << 32, /* 65 536 a turn */
            .translation_jump_counts = CRN_APP_JUMP_um,
            .rotation_jump_counts = 16384,
        };
        now[k] = (crn_port_hand){INT32_MAX - 10, INT32_MIN + 10};
    }
    crn_hands_reset(&hands);
    assert_true(crn_hands_update(&hands, 2, now, &found));
}

static void the_first_reading_is_the_zero_and_counts_may_wrap(void **state)
{
    (void)state;
    begin_hands();
    assert_int_equal(crn_hands_position(&hands, 0).feed_m_q30, 0);
    now[0].translation_counts = INT32_MIN + 989; /* 1000 counts on */
    now[0].rotation_counts = INT32_MAX - 15;     /* 26 counts back */
    assert_true(crn_hands_update(&hands, 2, now, &found));
    assert_in_range(crn_hands_position(&hands, 0).feed_m_q30, MM_Q30 - 1, MM_Q30 + 1);
    assert_int_equal(crn_hands_position(&hands, 0).turn32, 0u - (26u << 16));
    hands.tracks[0].is_translation_reversed = true;
    now[0].translation_counts += 1000;
    assert_true(crn_hands_update(&hands, 2, now, &found));
    assert_int_equal(crn_hands_position(&hands, 0).feed_m_q30, 0);
    assert_int_equal(found.count, 0);
}

static void expect_jump(int32_t translation_counts, int32_t rotation_counts, crn_finding expected)
{
    begin_hands();
    const crn_hands before = hands;
    now[0].translation_counts -= 100;
    now[1].translation_counts += translation_counts;
    now[1].rotation_counts += rotation_counts;
    const bool is_taken = crn_hands_update(&hands, 2, now, &found);
    assert_int_equal(is_taken, expected.code == CRN_FAULT_CODE_NONE);
    if (is_taken) return;
    assert_int_equal(found.count, 1);
    assert_int_equal(found.list[0].code, expected.code);
    assert_int_equal(found.list[0].value1, expected.value1);
    assert_int_equal(found.list[0].value2, expected.value2);
    assert_memory_equal(&hands, &before, sizeof hands);
}

/* The limits of a plausible encoder reading are a change of 5 mm and of a quarter turn in one tick. */
static void a_jump_of_one_encoder_is_found_and_no_hand_moves(void **state)
{
    (void)state;
    expect_jump(-5000, 16384, (crn_finding){CRN_FAULT_CODE_NONE, 0, 0});
    expect_jump(-5001, 0, (crn_finding){CRN_FAULT_CODE_ENCODER_JUMP_TRANSLATION, 1, -5001});
    expect_jump(-5001, 16385, (crn_finding){CRN_FAULT_CODE_ENCODER_JUMP_TRANSLATION, 1, -5001});
    expect_jump(0, 16385, (crn_finding){CRN_FAULT_CODE_ENCODER_JUMP_ROTATION, 1, 16385});
}

static void a_new_reference_is_no_jump(void **state)
{
    (void)state;
    begin_hands();
    crn_hands_take_reference(&hands);
    now[0] = now[1] = (crn_port_hand){0, 0};
    assert_true(crn_hands_update(&hands, 2, now, &found));
    assert_int_equal(crn_hands_position(&hands, 0).feed_m_q30, 0);
    assert_int_equal(found.count, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(force_and_torque_grow_by_their_slew_up_to_their_limits_and_fall_at_once),
        cmocka_unit_test(lower_limits_and_the_gain_hold),
        cmocka_unit_test(a_silent_host_takes_the_force_in_a_straight_line_within_12_ticks),
        cmocka_unit_test(a_coupling_takes_hand_and_tool_as_they_are_and_gives_no_force),
        cmocka_unit_test(a_lead_of_the_hand_is_a_force_on_it_and_a_step_of_the_tool),
        cmocka_unit_test(a_lead_about_the_line_is_a_torque),
        cmocka_unit_test(within_the_friction_the_tool_does_not_move),
        cmocka_unit_test(a_hand_slips_beyond_the_force_limit),
        cmocka_unit_test(a_force_that_gives_energy_is_reported_and_reduced_to_nothing),
        cmocka_unit_test(the_first_reading_is_the_zero_and_counts_may_wrap),
        cmocka_unit_test(a_jump_of_one_encoder_is_found_and_no_hand_moves),
        cmocka_unit_test(a_new_reference_is_no_jump),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
