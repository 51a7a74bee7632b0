/* These tests check the force that the motors are commanded to give, from samples alone, without a rod, a
 * scene or the wire protocol. The motor's force must stay within its limit and its slew limit. If nobody
 * holds a carriage, its motor's force must end within 32 ms. The device stops when a motor drives a carriage
 * too fast, when a track gives energy to the hand for 100 ms, and when a motor sustains an oscillation. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "firmware/app/safety/carriage.h"
#include "firmware/tests/reference/safety_bench.h"

static safety_bench bench;

static int32_t given(void)
{
    return bench.outputs.motors[0].axial_mN;
}

/* --- limit, slew, power --- */

/* Requirement: SR-01, SR-02 */
static void a_force_grows_by_the_slew_up_to_the_limit_and_falls_at_once(void **state)
{
    (void)state;
    for (int sign = -1; sign <= 1; sign += 2) {
        safety_bench_drive(&bench);
        for (int32_t i = 1; i <= 200; i++) {
            assert_int_equal(safety_bench_hold(&bench, sign * INT32_MAX, 1), 0);
            const int32_t expected = i < 160 ? 50 * i : 8000;
            assert_int_equal(given(), sign * expected);
        }
        assert_int_equal(safety_bench_hold(&bench, sign * 100, 1), 0);
        assert_int_equal(given(), sign * 100);
        assert_int_equal(safety_bench_hold(&bench, -sign * 8000, 1), 0);
        assert_int_equal(given(), -sign * 50);
    }
}

/* Requirement: SR-03 */
static void only_a_track_with_power_a_tool_a_coupling_and_a_sample_is_driven(void **state)
{
    (void)state;
    safety_bench_drive(&bench);
    for (int k = 0; k < CRN_PORT_TOOL_MAX; k++) bench.asked[k] = (crn_port_motor){30, 20};
    bench.safety.tracks[1].is_driven_along = bench.safety.tracks[1].is_driven_about = false;
    assert_int_equal(safety_bench_edge(&bench), CRN_FAULT_CODE_NONE);
    assert_int_equal(given(), 30);
    assert_int_equal(bench.outputs.motors[0].torque_uN_m, 20);
    for (int k = 1; k < CRN_PORT_TOOL_MAX; k++) {
        assert_int_equal(bench.outputs.motors[k].axial_mN, 0);
        assert_int_equal(bench.outputs.motors[k].torque_uN_m, 0);
    }
    bench.input.rig = NULL;
    crn_safety_drive(&bench.safety, &bench.input, bench.asked, &bench.outputs);
    assert_int_equal(given(), 0);
    safety_bench_rest(&bench);
    bench.asked[0].axial_mN = 30;
    assert_int_equal(safety_bench_edge(&bench), CRN_FAULT_CODE_NONE);
    assert_int_equal(given(), 0);
    assert_false(bench.outputs.enable);
}

/* Requirement: SR-03 */
static void the_drive_line_flips_once_per_edge_with_power_and_stands_without(void **state)
{
    (void)state;
    safety_bench_drive(&bench);
    for (int i = 0; i < 10; i++) {
        const bool before = bench.outputs.drive;
        (void)safety_bench_edge(&bench);
        assert_true(bench.outputs.enable);
        assert_int_equal(bench.outputs.drive, !before);
    }
    const bool last = bench.outputs.drive;
    bench.asked[0].axial_mN = 30;
    crn_safety_off(&bench.safety, &bench.outputs);
    for (int i = 0; i < 5; i++) {
        assert_false(bench.outputs.enable);
        assert_int_equal(bench.outputs.drive, last);
        assert_int_equal(given(), 0);
        (void)safety_bench_edge(&bench);
    }
}

static void power_begins_without_a_memory_of_earlier_faults(void **state)
{
    (void)state;
    safety_bench_drive(&bench);
    bench.rig.tracks[0].over_current = true;
    assert_int_equal(safety_bench_edge(&bench), CRN_FAULT_CODE_NONE);
    crn_safety_off(&bench.safety, &bench.outputs);
    crn_safety_on(&bench.safety, &bench.input);
    assert_int_equal(safety_bench_edge(&bench), CRN_FAULT_CODE_NONE);
    assert_int_equal(safety_bench_edge(&bench), CRN_FAULT_CODE_OVER_CURRENT);
}

/* --- a carriage that nobody holds --- */

/* Moves a carriage of 80 g from rest by its motor alone. */
typedef struct carriage {
    int64_t at_nm, speed_nm;
} carriage;

static void move(carriage *it)
{
    it->speed_nm -= (int64_t)bench.safety.driven[0].axial_mN * 1000 / 80; /* mN / kg = nm / ms^2 */
    it->at_nm += it->speed_nm;
    bench.rig.hands[0].translation_counts = (int32_t)(it->at_nm / 1000);
    bench.rig.tracks[0].force_raw = 0;
}

/* Requirement: SR-04 */
static void a_force_that_nobody_holds_ends_within_32_ms_at_a_hands_speed(void **state)
{
    (void)state;
    for (int32_t asked = -8000; asked <= 8000; asked += 1000) {
        carriage it = {0, 0};
        safety_bench_drive(&bench);
        assert_int_equal(safety_bench_hold(&bench, asked, 200), 0);
        assert_int_equal(given(), asked);
        for (int ms = 1; ms <= 200; ms++) {
            move(&it);
            assert_int_equal(safety_bench_edge(&bench), CRN_FAULT_CODE_NONE);
            assert_in_range(it.speed_nm + 250000, 0, 500000);
            if (ms >= 32) assert_in_range(given() + 40, 0, 80);
        }
    }
}

/* The carriage does not move in this test, so the speed limits have no effect. The motor's force stays
 * unchanged for the first 12 edges of the millisecond timer, and fades during the next 20 edges. */
/* Requirement: SR-04 */
static void a_force_that_nobody_holds_ends_in_time_without_any_motion(void **state)
{
    (void)state;
    safety_bench_drive(&bench);
    assert_int_equal(safety_bench_hold(&bench, 800, 100), 0);
    bench.rig.tracks[0].force_raw = 0;
    for (int ms = 1; ms <= 60; ms++) {
        assert_int_equal(safety_bench_edge(&bench), CRN_FAULT_CODE_NONE);
        const int32_t left = ms <= 12 ? 20 : ms < 32 ? 32 - ms : 0;
        assert_in_range(given(), 40 + 760 * left / 20 - 2, 40 + 760 * left / 20);
    }
}

/* The force sensor may be wrong by a quarter, so the hand may exert up to a third more than the measured
 * force; the code assumes this larger force. */
static void a_force_that_a_hand_holds_stays(void **state)
{
    (void)state;
    safety_bench_drive(&bench);
    assert_int_equal(safety_bench_hold(&bench, 4000, 200), 0);
    for (int ms = 0; ms < 500; ms++) {
        bench.rig.tracks[0].force_raw = 3000;
        bench.rig.hands[0].translation_counts -= 2; /* the hand gives way slowly */
        (void)safety_bench_edge(&bench);
        assert_int_equal(given(), 4000);
    }
}

/* --- what stops --- */

/* During the first `edges` edges of the timer, the motor gives 40 mN to a carriage at rest that nobody
 * touches. After the first `edges` edges of the timer, the carriage moves by `counts` encoder counts at every
 * edge, and the force sensor shows `felt_mN` millinewtons. */
static int run_away(int edges, int32_t counts, int32_t felt_mN)
{
    safety_bench_drive(&bench);
    bench.asked[0].axial_mN = -40;
    for (int i = 0; i < edges; i++) assert_int_equal(safety_bench_edge(&bench), CRN_FAULT_CODE_NONE);
    bench.rig.tracks[0].force_raw = felt_mN;
    for (int i = 1; i <= 10; i++) {
        bench.rig.hands[0].translation_counts += counts;
        if (safety_bench_edge(&bench) != CRN_FAULT_CODE_NONE) return i;
    }
    return 0;
}

/* One count of the encoder is subtracted before the speed is computed, because a reading may be one count too
 * large. After this subtraction, a travel of 252 um in 1 ms means a speed of at least 251 mm/s. If the
 * encoder moves by 250 um in each of eight milliseconds, the computed speed is just less than 250 mm/s. */
/* Requirement: SR-05 */
static void a_carriage_that_its_motor_made_fast_stops(void **state)
{
    (void)state;
    assert_int_equal(run_away(63, 252, 0), 2);
    assert_int_equal(bench.found.code, CRN_FAULT_CODE_CARRIAGE_FAST);
    assert_int_equal(bench.found.value2, 251);
    assert_false(bench.outputs.enable);
    assert_int_equal(run_away(63, 250, 0), 0);
    assert_int_equal(run_away(63, 252, 100), 0); /* a hand is felt */
    assert_int_equal(run_away(50, 252, 0), 0);   /* the motor gave too little: 2 mN s */
}

/* A hand has thrown the carriage, so the carriage is already fast at the first edge of the timer at which
 * nobody touches it. */
static void a_carriage_that_a_hand_throws_goes_on(void **state)
{
    (void)state;
    safety_bench_drive(&bench);
    bench.asked[0].axial_mN = -40;
    for (int i = 0; i < 300; i++) {
        bench.rig.tracks[0].force_raw = i < 50 ? 200 : 0;
        bench.rig.hands[0].translation_counts += 400;
        assert_int_equal(safety_bench_edge(&bench), CRN_FAULT_CODE_NONE);
    }
}

/* Requirement: SR-06 */
static void energy_that_a_track_gives_stops_at_the_hundredth_edge(void **state)
{
    (void)state;
    safety_bench_drive(&bench);
    bench.input.energy_pJ[1] = -10000000000;
    assert_int_equal(safety_bench_find(&bench, 500), 0);
    bench.input.energy_pJ[1]--;
    assert_int_equal(safety_bench_find(&bench, 99), 0);
    bench.input.energy_pJ[1]++;
    assert_int_equal(safety_bench_find(&bench, 1), 0);
    bench.input.energy_pJ[1]--;
    assert_int_equal(safety_bench_find(&bench, 200), 100);
    assert_int_equal(bench.found.code, CRN_FAULT_CODE_PASSIVITY_LASTS);
    assert_int_equal(bench.found.value1, 1);
    assert_int_equal(bench.found.value2, -10000);
}

/* Moves a carriage back and forth by 100 um per tick. The hand's force is `hand_mN` along the motion, and the
 * motor's force is `motor_mN` against the motion. Returns the number of ticks after which the device detects
 * the oscillation. */
static int oscillate(int ticks_per_swing, int32_t hand_mN, int32_t motor_mN, bool is_felt,
                     int narrower_counts)
{
    crn_safety_cycle cycle = {.direction = 0};
    int32_t step = 100;
    for (int ms = 1; ms <= 3000; ms++) {
        const int swing = (ms - 1) / ticks_per_swing, sign = swing % 2 == 0 ? 1 : -1;
        step = 100 - narrower_counts * swing;
        if (step <= 0) return 0;
        const crn_carriage_edge edge = {.moved_counts = sign * step,
                                        .driven_mN = sign * motor_mN,
                                        .measured_mN = sign * hand_mN,
                                        .pm_per_count = 1000000,
                                        .is_felt = is_felt};
        if (crn_cycle_lasts(&cycle, &edge)) return ms;
    }
    return 0;
}

/* The device detects the oscillation at a reversal of the carriage, once the swings after the first one have
 * lasted 25 ms. */
/* Requirement: SR-06 */
static void a_cycle_that_the_motor_sustains_is_found(void **state)
{
    (void)state;
    assert_int_equal(oscillate(20, -60, 100, true, 0), 61);
    assert_int_equal(oscillate(74, -60, 100, true, 0), 149);
}

static void a_cycle_of_the_hand_a_slow_one_a_small_one_and_one_that_ends_go_on(void **state)
{
    (void)state;
    assert_int_equal(oscillate(20, 60, 100, true, 0), 0);   /* the hand puts work in: a tremor */
    assert_int_equal(oscillate(76, -60, 100, true, 0), 0);  /* 152 ms */
    assert_int_equal(oscillate(20, -60, 50, true, 0), 0);   /* spans 100 mN */
    assert_int_equal(oscillate(20, -60, 100, true, 15), 0); /* each swing is less than 7/8 of the last one */
}

static void without_a_sensor_a_cycle_counts_from_one_newton(void **state)
{
    (void)state;
    assert_int_equal(oscillate(20, 0, 500, false, 0), 0);
    assert_int_equal(oscillate(20, 0, 501, false, 0), 61);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_force_grows_by_the_slew_up_to_the_limit_and_falls_at_once),
        cmocka_unit_test(only_a_track_with_power_a_tool_a_coupling_and_a_sample_is_driven),
        cmocka_unit_test(the_drive_line_flips_once_per_edge_with_power_and_stands_without),
        cmocka_unit_test(power_begins_without_a_memory_of_earlier_faults),
        cmocka_unit_test(a_force_that_nobody_holds_ends_within_32_ms_at_a_hands_speed),
        cmocka_unit_test(a_force_that_nobody_holds_ends_in_time_without_any_motion),
        cmocka_unit_test(a_force_that_a_hand_holds_stays),
        cmocka_unit_test(a_carriage_that_its_motor_made_fast_stops),
        cmocka_unit_test(a_carriage_that_a_hand_throws_goes_on),
        cmocka_unit_test(energy_that_a_track_gives_stops_at_the_hundredth_edge),
        cmocka_unit_test(a_cycle_that_the_motor_sustains_is_found),
        cmocka_unit_test(a_cycle_of_the_hand_a_slow_one_a_small_one_and_one_that_ends_go_on),
        cmocka_unit_test(without_a_sensor_a_cycle_counts_from_one_newton),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
