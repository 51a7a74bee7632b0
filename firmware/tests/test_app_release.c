/* These tests check the forces on a carriage (the moving handle of a track) that nobody holds. The motor's
 * force on a carriage that nobody holds ends within 32 ms, and the carriage gets no faster than a hand would
 * make it. If a motor nevertheless accelerates a released carriage, the device removes the motor power. A
 * hand that throws the carriage or moves it fast is not mistaken for a motor. The device ends an oscillation
 * that the control loop sustains in a hand, while a tremor of the hand may continue. The test sets the force
 * with which a hand holds the carriage, and the bench's force sensor reads this force. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/app/app_internal.h"
#include "firmware/tests/reference/bench_fixture.h"

enum { LOOSE_mN = 50 };

static int32_t motor_mN(void)
{
    return crn_sim_read_motors(b.host.sim).axial_mN[0];
}

static void expect_running(void)
{
    status = bench_status(&b);
    if (status.state != CRN_WIRE_STATE_RUNNING)
        fail_msg("ended by %s", crn_wire_fault_name(status.fault_code));
}

/* Runs one edge of the timer at which the carriage has moved by `um` and the hand holds it with the force
 * `held_mN`. The simulated device adds the motor's force to `force_raw`, so the function subtracts the
 * motor's force beforehand. */
static void edge(int32_t um, int32_t held_mN)
{
    b.rig.hands[0].translation_counts += um;
    b.rig.tracks[0].force_raw = held_mN - motor_mN();
    bench_tick(&b);
}

/* Starts a session with a wire in a seal of 2 N friction. The hand has pushed the wire in by `um` against the
 * coupling of 1 N/mm, and then holds still. */
static void push_seal(int32_t um)
{
    crn_wire_track track = client_plain_track();
    track.seal_mN = 2000;
    track.coupling_uN_m_per_rad = track.coupling_nN_m_s_per_rad = 0;
    bench_drain(&b);
    client_rig(&b.host, &track, 1);
    assert_true(client_expect_status(&b.host, &status));
    assert_true(bench_power(&b));
    for (int32_t i = 0; i < um / 10; i++) edge(10, motor_mN());
    for (int i = 0; i < 20; i++) edge(0, motor_mN());
    assert_in_range(motor_mN(), um - 100, um + 100);
}

/* No hand opposes the motor's 0.8 N, and friction keeps the carriage at rest. At first all of the motor's
 * force remains; then the force falls from tick to tick until it is less than a hand can feel. The motor's
 * force returns when a hand holds the carriage again. */
static void a_force_that_nobody_holds_goes(void **state)
{
    (void)state;
    push_seal(800);
    int32_t last = motor_mN();
    for (int i = 0; i < 40; i++) {
        edge(0, 0);
        assert_true(motor_mN() <= last);
        last = motor_mN();
    }
    assert_true(last <= LOOSE_mN);
    expect_running();
    for (int i = 0; i < 100; i++) edge(0, motor_mN() + 60);
    assert_in_range(motor_mN(), 700, 900);
}

/* A motor force of 0.8 N makes a carriage oscillate if no hand holds the carriage; after 32 ms the
 * oscillation must be over.
 */
static void a_cycle_of_a_carriage_that_nobody_holds_ends(void **state)
{
    (void)state;
    int32_t at = 0, largest = 0;
    push_seal(800);
    for (int i = 0; i < 300; i++) {
        const int32_t to = (int32_t)lround(800 * (cos(i * 0.1) - 1)); /* 16 Hz, 80 mm/s */
        edge(to - at, 0);
        at = to;
        if (i >= 100 && abs(motor_mN()) > largest) largest = abs(motor_mN());
    }
    assert_true(largest <= LOOSE_mN);
}

/* The carriage moves away from the wall in the direction of its motor's force. If the carriage would reach
 * 0.1 m/s in the next tick, the device reduces the motor's force to the force that a hand opposes. */
static void a_carriage_that_runs_along_its_force_loses_it(void **state)
{
    (void)state;
    push_seal(1800);
    edge(-14, 0);
    const int32_t slow_mN = motor_mN();
    edge(-59, 0);
    print_message("# at 14 mm/s %d mN, at 59 mm/s %d mN\n", slow_mN, motor_mN());
    assert_true(slow_mN > 1500 && motor_mN() <= LOOSE_mN);
}

/* --- causes of a stop --- */

/* No hand touches the carriage. With a force of 1.8 N from its motor, the carriage becomes 20 to 40 mm/s
 * faster in each millisecond, as if the motor gave more force than the device commanded. */
static void a_carriage_that_its_motor_drives_too_fast_takes_the_power(void **state)
{
    (void)state;
    int edges = 0, fast = 0;
    push_seal(1800);
    for (int32_t speed = 20; crn_sim_read_motors(b.host.sim).drive && edges < 40; edges++, speed += 40) {
        edge(-speed, 0);
        fast += speed > 250;
    }
    print_message("# %d edges, %d of them above 0.25 m/s\n", edges, fast);
    status = bench_status(&b);
    assert_int_equal(status.state, CRN_WIRE_STATE_FAULT);
    assert_int_equal(status.fault_code, CRN_FAULT_CODE_CARRIAGE_FAST);
    assert_in_range(fast, 1, crn_wire_fault_safe_ms(CRN_FAULT_CODE_CARRIAGE_FAST) + 1);
}

/* A hand has thrown the carriage at 0.5 m/s against the coupling and released it, so the hand caused the
 * speed. */
static void a_carriage_that_was_thrown_is_no_fault(void **state)
{
    (void)state;
    assert_true(bench_power(&b));
    for (int32_t speed = 0; speed <= 500; speed += 25) edge(speed, motor_mN() + 600);
    for (int32_t speed = 500; speed >= 0; speed -= 10) edge(speed, 0);
    expect_running();
}

/* The hand moves towards the patient at 0.25 m/s against a seal that slips at 0.3 N, and moves back at 0.5
 * m/s. The carriage of 80 g needs a force of 0.4 N for the hand's acceleration of 5 m/s^2. */
static void a_fast_hand_is_no_fault(void **state)
{
    (void)state;
    crn_wire_track track = client_plain_track();
    track.seal_mN = 300;
    bench_drain(&b);
    client_rig(&b.host, &track, 1);
    assert_true(client_expect_status(&b.host, &status));
    assert_true(bench_power(&b));
    int32_t speed = 0;
    for (int round = 0; round < 6; round++) {
        const int32_t wanted = round % 2 ? -500 : 250;
        for (int i = 0; i < (round % 2 ? 160 : 320); i++) {
            const int32_t gain = wanted > speed ? 5 : wanted < speed ? -5 : 0;
            speed += gain;
            edge(speed, motor_mN() + 80 * gain + speed);
        }
    }
    expect_running();
}

/* The motor's force oscillates with 0.3 N at 20 Hz, and the hand moves with this force as if the motor shook
 * the hand. In each oscillation of the hand, the motor does work on the hand. The oscillation ends within 0.2
 * s. */
static void a_cycle_that_the_loop_keeps_up_in_a_hand_takes_the_power(void **state)
{
    (void)state;
    int32_t at = 0;
    int ms = 0;
    push_seal(1000);
    for (; ms < 1000 && crn_sim_read_motors(b.host.sim).drive; ms++) {
        const int32_t to = (int32_t)lround(300 * sin(ms * 0.125));
        edge(to - at, motor_mN() - (int32_t)lround(100 * cos(ms * 0.125)));
        at = to;
    }
    status = bench_status(&b);
    assert_int_equal(status.fault_code, CRN_FAULT_CODE_PASSIVITY_LASTS);
    print_message("# a cycle of 0.3 N at 20 Hz ends after %d ms\n", ms);
    assert_in_range(ms, 50, 200);
}

/* A trembling hand moves the carriage like an oscillation that the motor sustains, but in a tremor the hand
 * does the work. */
static void a_tremor_goes_on(void **state)
{
    (void)state;
    int32_t at = 0;
    push_seal(1000);
    for (int ms = 0; ms < 1000; ms++) {
        const int32_t to = (int32_t)lround(300 * sin(ms * 0.0628));
        edge(to - at, motor_mN() + (int32_t)lround(30 * cos(ms * 0.0628)));
        at = to;
    }
    expect_running();
}

/* A heart at 200 beats a minute moves the vessel wall, and through the tool the wall moves the hand. */
static void a_heart_in_the_hand_is_no_cycle(void **state)
{
    (void)state;
    int32_t at = 0;
    push_seal(1000);
    for (int ms = 0; ms < 3000; ms++) {
        const int32_t to = (int32_t)lround(100 * sin(ms * 0.021));
        edge(to - at, motor_mN() - (int32_t)lround(30 * cos(ms * 0.021)));
        at = to;
    }
    expect_running();
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_force_that_nobody_holds_goes),
        TEST(a_cycle_of_a_carriage_that_nobody_holds_ends),
        TEST(a_carriage_that_runs_along_its_force_loses_it),
        TEST(a_carriage_that_its_motor_drives_too_fast_takes_the_power),
        TEST(a_carriage_that_was_thrown_is_no_fault),
        TEST(a_fast_hand_is_no_fault),
        TEST(a_cycle_that_the_loop_keeps_up_in_a_hand_takes_the_power),
        TEST(a_tremor_goes_on),
        TEST(a_heart_in_the_hand_is_no_cycle),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
