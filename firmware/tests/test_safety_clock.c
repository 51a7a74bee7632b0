/* These tests check the device's reactions to time, from the clock's readings alone, without a rod, a scene
 * or the wire protocol. If the processor stops, or the ticks fall behind, the device removes the motor power.
 * If the host is silent, the forces fade within 42 ms. Before the motors get power, a host must send back a
 * code that the device has sent. Any answer, right or wrong, uses up the device's code; the code and the
 * permission to power the motors also expire. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "firmware/app/safety/clock.h"
#include "firmware/app/safety/limits.h"
#include "firmware/app/safety/permission.h"
#include "firmware/app/safety/watchdog.h"

static void expect(const crn_finding *found, crn_fault_code code, int32_t value1, int32_t value2)
{
    assert_int_equal(found->code, code);
    assert_int_equal(found->value1, value1);
    assert_int_equal(found->value2, value2);
}

/* --- the clock --- */

/* Runs two edges of the timer that are `gap_us` apart; the clock wraps between them. */
static crn_findings edges_apart(uint32_t gap_us, bool is_driving)
{
    crn_clock clock = {.has_edge = false};
    crn_findings findings = {.count = 0};
    crn_clock_begin(&clock, UINT32_MAX - 100, is_driving, &findings);
    crn_clock_begin(&clock, UINT32_MAX - 100 + gap_us, is_driving, &findings);
    return findings;
}

/* Requirement: SR-17 */
static void edges_more_than_5_ms_apart_take_the_power(void **state)
{
    (void)state;
    assert_int_equal(edges_apart(5000, true).count, 0);
    assert_int_equal(edges_apart(1000000, false).count, 0);
    const crn_findings found = edges_apart(5001, true);
    assert_int_equal(found.count, 1);
    expect(&found.list[0], CRN_FAULT_CODE_TICK_STALLED, 5001, 0);
}

static void the_first_edge_with_power_has_none_before_it(void **state)
{
    (void)state;
    crn_clock clock = {.has_edge = false};
    crn_findings findings = {.count = 0};
    crn_clock_begin(&clock, 0, false, &findings);
    crn_clock_restart(&clock);
    crn_clock_begin(&clock, 1000000, true, &findings);
    assert_int_equal(findings.count, 0);
}

static crn_findings tick(crn_clock *clock, uint32_t begin_us, uint32_t took_us)
{
    crn_findings findings = {.count = 0};
    crn_clock_begin(clock, begin_us, true, &findings);
    crn_clock_end(clock, begin_us + took_us, true, &findings);
    return findings;
}

static void a_late_tick_is_reported_and_made_up_for(void **state)
{
    (void)state;
    crn_clock clock = {.has_edge = false};
    assert_int_equal(tick(&clock, 0, 1000).count, 0);
    const crn_findings late = tick(&clock, 1000, 1800);
    assert_int_equal(late.count, 1);
    expect(&late.list[0], CRN_FAULT_CODE_TICK_OVERRUN, 1800, 800);
    assert_true(clock.was_late);
    assert_int_equal(tick(&clock, 2000, 100).count, 0);
    assert_false(clock.was_late);
    assert_int_equal(clock.tick_overruns, 1);
    assert_int_equal(clock.tick_us_max, 1800);
}

/* Requirement: SR-17 */
static void a_backlog_of_more_than_2_ms_takes_the_power_after_its_overrun(void **state)
{
    (void)state;
    crn_clock clock = {.has_edge = false};
    assert_int_equal(tick(&clock, 0, 3000).count, 1);
    const crn_findings stalled = tick(&clock, 3000, 1001);
    assert_int_equal(stalled.count, 2);
    expect(&stalled.list[0], CRN_FAULT_CODE_TICK_OVERRUN, 1001, 2001);
    expect(&stalled.list[1], CRN_FAULT_CODE_TICK_STALLED, 1001, 2001);
    crn_findings without_power = {.count = 0};
    clock = (crn_clock){.has_edge = true};
    crn_clock_end(&clock, 9000, false, &without_power);
    assert_int_equal(without_power.count, 1);
}

/* --- the host's silence --- */

/* Requirement: SR-16 */
static void a_silent_host_is_reported_once_after_30_ticks_and_faded_out_after_42(void **state)
{
    (void)state;
    crn_watchdog watchdog = {.silent_ticks = 0};
    uint32_t left = CRN_APP_FADE_ticks;
    for (int ms = 1; ms <= 100; ms++) {
        crn_findings findings = {.count = 0};
        crn_watchdog_tick(&watchdog, &findings);
        assert_int_equal(findings.count, ms == 30);
        if (ms == 30) expect(&findings.list[0], CRN_FAULT_CODE_HOST_SILENT, 30, 0);
        if (ms > 30 && left > 0) left--;
        assert_int_equal(crn_watchdog_is_fading(&watchdog), ms >= 30);
        assert_int_equal(crn_watchdog_left_ticks(&watchdog), left);
        assert_int_equal(left == 0, ms >= 42);
    }
    assert_true(crn_watchdog_feed(&watchdog));
    assert_false(crn_watchdog_feed(&watchdog));
    assert_int_equal(crn_watchdog_left_ticks(&watchdog), CRN_APP_FADE_ticks);
}

static void a_frame_every_29_ticks_is_no_silence(void **state)
{
    (void)state;
    crn_watchdog watchdog = {.silent_ticks = 0};
    crn_findings findings = {.count = 0};
    for (int ms = 1; ms <= 2900; ms++) {
        crn_watchdog_tick(&watchdog, &findings);
        if (ms % 29 == 0) assert_false(crn_watchdog_feed(&watchdog));
    }
    assert_int_equal(findings.count, 0);
}

/* --- the permission --- */

/* Requirement: SR-08 */
static void only_the_code_itself_is_the_right_answer_and_only_once(void **state)
{
    (void)state;
    crn_permission permission = {.code = 0};
    assert_false(crn_permission_answer(&permission, 0)); /* nothing was offered */
    crn_permission_offer(&permission, 0);
    const uint32_t first = permission.code;
    assert_int_not_equal(first, 0);
    assert_false(permission.is_given);
    assert_true(crn_permission_answer(&permission, first));
    assert_false(crn_permission_answer(&permission, first));
    crn_permission_offer(&permission, 0); /* at the same time of the clock, another code */
    const uint32_t second = permission.code;
    assert_int_not_equal(second, first);
    assert_false(crn_permission_answer(&permission, first));
    assert_false(crn_permission_answer(&permission, second)); /* the wrong answer has spent it */
}

static void a_code_and_a_permission_expire_after_2_s(void **state)
{
    (void)state;
    crn_permission permission = {.code = 0};
    crn_permission_offer(&permission, 12345);
    const uint32_t code = permission.code;
    for (int ms = 0; ms < CRN_APP_CODE_ticks; ms++) crn_permission_age(&permission);
    assert_int_equal(permission.code, code);
    crn_permission_age(&permission);
    assert_false(crn_permission_answer(&permission, code));
    crn_permission_give(&permission);
    for (int ms = 0; ms < CRN_APP_CODE_ticks; ms++) crn_permission_age(&permission);
    assert_true(permission.is_given);
    crn_permission_age(&permission);
    assert_false(permission.is_given);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(edges_more_than_5_ms_apart_take_the_power),
        cmocka_unit_test(the_first_edge_with_power_has_none_before_it),
        cmocka_unit_test(a_late_tick_is_reported_and_made_up_for),
        cmocka_unit_test(a_backlog_of_more_than_2_ms_takes_the_power_after_its_overrun),
        cmocka_unit_test(a_silent_host_is_reported_once_after_30_ticks_and_faded_out_after_42),
        cmocka_unit_test(a_frame_every_29_ticks_is_no_silence),
        cmocka_unit_test(only_the_code_itself_is_the_right_answer_and_only_once),
        cmocka_unit_test(a_code_and_a_permission_expire_after_2_s),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
