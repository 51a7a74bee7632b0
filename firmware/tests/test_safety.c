/* These tests check the safety checks that run at every edge of the timer, from samples alone, without a rod,
 * a scene or the wire protocol. The tests try each limit with a value just below it and a value just above
 * it. Each fault must have the code and the number of timer edges that shared/wire/wire_faults.def states. In
 * a rig at rest, the checks find no fault. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "firmware/tests/reference/safety_bench.h"

static safety_bench bench;

static void expect_found(crn_fault_code code, int edges, int edges_expected)
{
    if (bench.found.code != code || edges != edges_expected)
        fail_msg("fault %d after %d edges, expected %d after %d", bench.found.code, edges, code,
                 edges_expected);
    assert_false(bench.outputs.enable);
    for (int k = 0; k < CRN_PORT_TOOL_MAX; k++) assert_int_equal(bench.outputs.motors[k].axial_mN, 0);
}

static void a_rig_at_rest_is_well_with_and_without_power(void **state)
{
    (void)state;
    safety_bench_rest(&bench);
    assert_int_equal(safety_bench_find(&bench, 1000), 0);
    safety_bench_drive(&bench);
    assert_int_equal(safety_bench_find(&bench, 1000), 0);
}

/* --- lines --- */

/* Requirement: SR-14 */
static void each_line_takes_the_power_at_its_edge(void **state)
{
    (void)state;
    safety_bench_drive(&bench);
    bench.rig.emergency_stop = true;
    expect_found(CRN_FAULT_CODE_EMERGENCY_STOP, safety_bench_find(&bench, 5), 1);
    safety_bench_drive(&bench);
    bench.rig.supply_good = false;
    expect_found(CRN_FAULT_CODE_SUPPLY_LOST, safety_bench_find(&bench, 5), 1);
    safety_bench_drive(&bench);
    bench.input.rig = NULL;
    expect_found(CRN_FAULT_CODE_RIG_LOST, safety_bench_find(&bench, 5), 1);
}

static void lines_of_a_rig_without_power_are_no_fault(void **state)
{
    (void)state;
    safety_bench_rest(&bench);
    bench.rig.emergency_stop = true;
    bench.rig.supply_good = false;
    assert_int_equal(safety_bench_find(&bench, 100), 0);
    bench.input.rig = NULL;
    assert_int_equal(safety_bench_find(&bench, 100), 0);
}

/* Requirement: SR-15 */
static void a_stage_that_went_off_or_never_comes_on_is_lost(void **state)
{
    (void)state;
    safety_bench_drive(&bench);
    bench.rig.stage_on = false;
    expect_found(CRN_FAULT_CODE_STAGE_LOST, safety_bench_find(&bench, 5), 1);
    safety_bench_rest(&bench);
    crn_safety_on(&bench.safety, &bench.input);
    int edges = 0;
    do {
        bench.rig.stage_on = false;
        edges++;
    } while (safety_bench_edge(&bench) == CRN_FAULT_CODE_NONE);
    expect_found(CRN_FAULT_CODE_STAGE_LOST, edges, CRN_PORT_DRIVE_HOLD_ms + 4);
}

/* Requirement: SR-15 */
static void a_stage_that_stays_on_is_reported_once_in_any_state(void **state)
{
    (void)state;
    safety_bench_drive(&bench);
    crn_safety_off(&bench.safety, &bench.outputs);
    assert_true(bench.rig.stage_on);
    expect_found(CRN_FAULT_CODE_STAGE_STUCK, safety_bench_find(&bench, 20), CRN_PORT_DRIVE_HOLD_ms + 4);
    bench.input.is_stopped = true;
    assert_int_equal(safety_bench_find(&bench, 100), 0);
    bench.rig.stage_on = false;
    assert_int_equal(safety_bench_find(&bench, 10), 0);
    bench.rig.stage_on = true;
    expect_found(CRN_FAULT_CODE_STAGE_STUCK, safety_bench_find(&bench, 5), 1);
}

static void in_state_fault_nothing_else_is_reported(void **state)
{
    (void)state;
    safety_bench_rest(&bench);
    bench.input.is_stopped = true;
    bench.rig.tracks[0].force_raw = 30000;
    bench.rig.emergency_stop = true;
    assert_int_equal(safety_bench_find(&bench, 100), 0);
}

/* --- sensors --- */

/* Requirement: SR-12 */
static void a_lost_encoder_takes_the_power_of_a_track_with_a_tool(void **state)
{
    (void)state;
    safety_bench_drive(&bench);
    bench.rig.tracks[2].translation_sensor = CRN_PORT_SENSOR_ERROR; /* no tool is there */
    assert_int_equal(safety_bench_find(&bench, 10), 0);
    bench.rig.tracks[1].translation_sensor = CRN_PORT_SENSOR_ERROR;
    expect_found(CRN_FAULT_CODE_ENCODER_LOST, safety_bench_find(&bench, 5), 1);
    assert_int_equal(bench.found.value1, 1);
    assert_int_equal(bench.found.value2, 0);
    safety_bench_drive(&bench);
    bench.rig.tracks[0].rotation_sensor = CRN_PORT_SENSOR_RANGE;
    expect_found(CRN_FAULT_CODE_ENCODER_LOST, safety_bench_find(&bench, 5), 1);
    assert_int_equal(bench.found.value2, 1);
}

/* Requirement: SR-13 */
static void a_force_sensor_is_lost_by_its_word_by_absence_or_by_an_impossible_force(void **state)
{
    (void)state;
    static const uint8_t words[] = {CRN_PORT_SENSOR_ABSENT, CRN_PORT_SENSOR_RANGE, CRN_PORT_SENSOR_ERROR};
    for (size_t i = 0; i < sizeof words; i++) {
        safety_bench_drive(&bench);
        bench.rig.tracks[0].force_sensor = words[i];
        expect_found(CRN_FAULT_CODE_FORCE_SENSOR_LOST, safety_bench_find(&bench, 5), 1);
    }
    safety_bench_drive(&bench);
    bench.rig.tracks[0].force_raw = -50001;
    expect_found(CRN_FAULT_CODE_FORCE_SENSOR_LOST, safety_bench_find(&bench, 5), 1);
    safety_bench_rest(&bench); /* a rig that never had one */
    bench.rig.tracks[0].force_sensor = CRN_PORT_SENSOR_ABSENT;
    crn_safety_on(&bench.safety, &bench.input);
    assert_int_equal(safety_bench_find(&bench, 100), 0);
}

/* Requirement: SR-14 */
static void an_over_current_counts_from_its_second_edge_in_a_row(void **state)
{
    (void)state;
    safety_bench_drive(&bench);
    for (int i = 0; i < 10; i++) { /* spikes */
        bench.rig.tracks[0].over_current = i % 2 == 0;
        assert_int_equal(safety_bench_edge(&bench), CRN_FAULT_CODE_NONE);
    }
    bench.rig.tracks[0].over_current = true;
    expect_found(CRN_FAULT_CODE_OVER_CURRENT, safety_bench_find(&bench, 5), 2);
}

/* --- forces --- */

/* The border is limit + limit / 8 + 200 mN. */
/* Requirement: SR-10 */
static void a_force_beyond_the_limit_counts_from_its_second_edge(void **state)
{
    (void)state;
    for (int sign = -1; sign <= 1; sign += 2) {
        safety_bench_drive(&bench);
        assert_int_equal(safety_bench_hold(&bench, sign * 8000, 200), 0);
        bench.rig.tracks[0].force_raw = sign * 9200;
        assert_int_equal(safety_bench_find(&bench, 2), 0);
        assert_int_equal(safety_bench_hold(&bench, sign * 8000, 2), 0);
        bench.rig.tracks[0].force_raw = sign * 9201;
        expect_found(CRN_FAULT_CODE_FORCE_OVER, safety_bench_find(&bench, 5), 2);
        assert_int_equal(bench.found.value2, sign * 9201);
    }
}

static void a_lower_limit_is_kept_too(void **state)
{
    (void)state;
    safety_bench_drive(&bench);
    bench.safety.tracks[0].force_limit_mN = 800;
    assert_int_equal(safety_bench_hold(&bench, 8000, 200), 0);
    assert_int_equal(bench.safety.driven[0].axial_mN, 800);
    bench.rig.tracks[0].force_raw = 1101;
    expect_found(CRN_FAULT_CODE_FORCE_OVER, safety_bench_find(&bench, 5), 2);
}

/* Requirement: SR-11 */
static void a_force_that_nobody_asked_for_counts_in_every_state_from_its_third_edge(void **state)
{
    (void)state;
    safety_bench_rest(&bench);
    bench.rig.tracks[2].force_raw = 1000;
    assert_int_equal(safety_bench_find(&bench, 100), 0);
    bench.rig.tracks[2].force_raw = 1001;
    expect_found(CRN_FAULT_CODE_ACTUATOR_STUCK_ON, safety_bench_find(&bench, 5), 3);
    assert_int_equal(bench.found.value1, 2);
}

/* The requested force is 400 mN, so the border of the measured force is 400 + 1000 + 400 / 4 mN. */
/* Requirement: SR-11 */
static void a_force_larger_than_asked_for_is_a_mismatch_from_its_third_edge(void **state)
{
    (void)state;
    safety_bench_drive(&bench);
    assert_int_equal(safety_bench_hold(&bench, 400, 50), 0);
    bench.rig.tracks[0].force_raw = 1501;
    expect_found(CRN_FAULT_CODE_FORCE_MISMATCH, safety_bench_find(&bench, 5), 3);
    safety_bench_drive(&bench);
    assert_int_equal(safety_bench_hold(&bench, 400, 50), 0);
    bench.rig.tracks[0].force_raw = 1500;
    for (int i = 0; i < 3; i++) assert_int_equal(safety_bench_edge(&bench), CRN_FAULT_CODE_NONE);
}

static void the_sensors_zero_and_scale_are_those_of_the_track(void **state)
{
    (void)state;
    safety_bench_rest(&bench);
    bench.safety.tracks[0].force_zero_counts = 100;
    bench.safety.tracks[0].force_uN_per_count = 2500;
    bench.rig.tracks[0].force_raw = 300;
    assert_int_equal(crn_safety_force_mN(&bench.safety, &bench.rig, 0), 500);
    bench.rig.tracks[0].force_sensor = CRN_PORT_SENSOR_ERROR;
    assert_int_equal(crn_safety_force_mN(&bench.safety, &bench.rig, 0), 0);
    assert_int_equal(crn_safety_force_mN(&bench.safety, NULL, 0), 0);
}

/* --- balance --- */

/* A hand pulls with 950 mN, and the carriage moves by `counts` encoder counts at every edge. The heaviest
 * carriage needs four edges of the timer to move 20 um. */
static int pull(int32_t counts)
{
    safety_bench_drive(&bench);
    bench.rig.tracks[0].force_raw = 950;
    for (int i = 1; i <= 10; i++) {
        bench.rig.hands[0].translation_counts += counts;
        if (safety_bench_edge(&bench) != CRN_FAULT_CODE_NONE) return i;
    }
    return 0;
}

/* Requirement: SR-12 */
static void an_unbalanced_force_must_move_the_encoder_its_own_way(void **state)
{
    (void)state;
    expect_found(CRN_FAULT_CODE_ENCODER_STUCK, pull(0), 4);
    expect_found(CRN_FAULT_CODE_ENCODER_REVERSED, pull(-8), 4);
    assert_int_equal(pull(8), 0);
}

/* An encoder whose counts are absurd, at the coarsest scale, against the pull of a hand. Each change counts
 * as twice the largest plausible jump, so no sum overflows. Unlimited, the product of counts and scale would
 * exceed 2^63 nm, and would change its sign. */
/* Requirement: SR-12 */
static void an_encoder_that_leaps_backwards_is_reversed_at_any_size(void **state)
{
    (void)state;
    safety_bench_drive(&bench);
    bench.safety.tracks[0].translation_pm_per_count = 500000000;
    bench.safety.tracks[0].jump_counts = CRN_APP_JUMP_um / 500;
    bench.rig.tracks[0].force_raw = 950;
    int edges = 0;
    do {
        const uint32_t counts = (uint32_t)bench.rig.hands[0].translation_counts;
        bench.rig.hands[0].translation_counts = (int32_t)(counts - 667000000u);
        edges++;
    } while (safety_bench_edge(&bench) == CRN_FAULT_CODE_NONE && edges < 100);
    expect_found(CRN_FAULT_CODE_ENCODER_REVERSED, edges, 39);
}

static void a_balanced_force_may_stand_still(void **state)
{
    (void)state;
    safety_bench_drive(&bench);
    bench.rig.tracks[0].force_raw = 899; /* friction may hold this */
    assert_int_equal(safety_bench_find(&bench, 500), 0);
    safety_bench_drive(&bench);
    assert_int_equal(safety_bench_hold(&bench, 3000, 500), 0);
}

/* --- may the motors be armed? --- */

static void expect_ready(crn_fault_code code)
{
    assert_int_equal(crn_safety_ready(&bench.safety, &bench.input), code);
    safety_bench_rest(&bench);
}

static void the_first_reason_against_power_is_named(void **state)
{
    (void)state;
    safety_bench_rest(&bench);
    expect_ready(CRN_FAULT_CODE_NONE);
    bench.input.rig = NULL;
    expect_ready(CRN_FAULT_CODE_RIG_LOST);
    bench.rig.emergency_stop = true;
    bench.rig.supply_good = false;
    expect_ready(CRN_FAULT_CODE_EMERGENCY_STOP);
    bench.rig.supply_good = false;
    expect_ready(CRN_FAULT_CODE_SUPPLY_LOST);
    bench.rig.stage_on = true;
    bench.safety.idle_ticks = CRN_PORT_DRIVE_HOLD_ms + 4;
    expect_ready(CRN_FAULT_CODE_STAGE_STUCK);
    bench.rig.tracks[1].rotation_sensor = CRN_PORT_SENSOR_ERROR;
    expect_ready(CRN_FAULT_CODE_ENCODER_LOST);
    bench.rig.tracks[1].force_sensor = CRN_PORT_SENSOR_ERROR;
    expect_ready(CRN_FAULT_CODE_FORCE_SENSOR_LOST);
    bench.rig.tracks[0].force_raw = -1001;
    expect_ready(CRN_FAULT_CODE_ACTUATOR_STUCK_ON);
    bench.rig.tracks[0].over_current = true;
    expect_ready(CRN_FAULT_CODE_OVER_CURRENT);
    bench.rig.tracks[2].over_current = true; /* no tool is there */
    expect_ready(CRN_FAULT_CODE_NONE);
}

/* Requirement: SR-13 */
static void a_track_without_a_force_sensor_needs_the_local_unlock(void **state)
{
    (void)state;
    safety_bench_rest(&bench);
    bench.rig.tracks[0].force_sensor = CRN_PORT_SENSOR_ABSENT;
    expect_ready(CRN_FAULT_CODE_FORCE_SENSOR_LOST);
    bench.rig.tracks[0].force_sensor = CRN_PORT_SENSOR_ABSENT;
    bench.rig.local_unlock = true;
    expect_ready(CRN_FAULT_CODE_NONE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_rig_at_rest_is_well_with_and_without_power),
        cmocka_unit_test(each_line_takes_the_power_at_its_edge),
        cmocka_unit_test(lines_of_a_rig_without_power_are_no_fault),
        cmocka_unit_test(a_stage_that_went_off_or_never_comes_on_is_lost),
        cmocka_unit_test(a_stage_that_stays_on_is_reported_once_in_any_state),
        cmocka_unit_test(in_state_fault_nothing_else_is_reported),
        cmocka_unit_test(a_lost_encoder_takes_the_power_of_a_track_with_a_tool),
        cmocka_unit_test(a_force_sensor_is_lost_by_its_word_by_absence_or_by_an_impossible_force),
        cmocka_unit_test(an_over_current_counts_from_its_second_edge_in_a_row),
        cmocka_unit_test(a_force_beyond_the_limit_counts_from_its_second_edge),
        cmocka_unit_test(a_lower_limit_is_kept_too),
        cmocka_unit_test(a_force_that_nobody_asked_for_counts_in_every_state_from_its_third_edge),
        cmocka_unit_test(a_force_larger_than_asked_for_is_a_mismatch_from_its_third_edge),
        cmocka_unit_test(the_sensors_zero_and_scale_are_those_of_the_track),
        cmocka_unit_test(an_unbalanced_force_must_move_the_encoder_its_own_way),
        cmocka_unit_test(an_encoder_that_leaps_backwards_is_reversed_at_any_size),
        cmocka_unit_test(a_balanced_force_may_stand_still),
        cmocka_unit_test(the_first_reason_against_power_is_named),
        cmocka_unit_test(a_track_without_a_force_sensor_needs_the_local_unlock),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
