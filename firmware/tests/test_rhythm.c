/* Claims about heartbeat and breath. Heartbeats have the ordered length. The tests show that the length of
 * systole follows its formula and not the interval between beats, and that the phase has no jumps whatever
 * the host commands. The intervals between heartbeats have the set variability, and vary in the same way on
 * every run. A premature beat is followed by a pause, after which the beats come at the same times as without
 * the premature beat. A command to the heart with a value out of its range has no effect. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "firmware/core/rhythm.h"
#include "firmware/tests/reference/random.h"

static const crn_rhythm_order nothing = {CRN_RHYTHM_KEEP, 0};

static void ask(crn_rhythm *rhythm, uint32_t action, uint32_t value)
{
    const crn_rhythm_order order = {action, value};
    assert_true(crn_rhythm_order_is_valid(&order));
    crn_rhythm_step(rhythm, &order);
}

/* Returns the number of ticks until the next heartbeat begins; the phase must rise all the time. */
static uint32_t to_next_beat(crn_rhythm *rhythm)
{
    uint32_t ticks = 0, count = rhythm->beat_count, phase = rhythm->heart_phase32;
    while (rhythm->beat_count == count) {
        crn_rhythm_step(rhythm, &nothing);
        ticks++;
        assert_true(ticks < 10000 && crn_rhythm_is_valid(rhythm));
        if (rhythm->beat_count == count) assert_true(rhythm->heart_phase32 > phase);
        phase = rhythm->heart_phase32;
    }
    assert_int_equal(rhythm->heart_phase32, 0);
    return ticks;
}

/* The interval between heartbeats is 60 000 ms divided by the heart rate in beats a minute, within 1 ms. The
 * aortic valve closes (540 - 2.1 rate) ms after the QRS complex, where `rate` is in beats a minute. The time
 * from the QRS complex to the valve's closure is 456 ms at 40 beats a minute and 204 ms at 160 beats a
 * minute. Systole at 70 beats a minute lasts 393 ms. If systole were always the same part of the interval, it
 * would last 624 ms at 40 beats a minute. */
static void systole_follows_its_formula_and_not_the_interval(void **state)
{
    (void)state;
    for (uint32_t rate = CRN_HEART_RATE_MIN_per_min; rate <= CRN_HEART_RATE_MAX_per_min; rate += 10) {
        crn_rhythm rhythm;
        crn_rhythm_init(&rhythm);
        ask(&rhythm, CRN_RHYTHM_HEART_RATE, rate);
        to_next_beat(&rhythm);
        uint32_t systole = 0;
        while (rhythm.heart_phase32 < CRN_PHASE_SYSTOLE_END) {
            crn_rhythm_step(&rhythm, &nothing);
            systole++;
        }
        const uint32_t interval = systole + to_next_beat(&rhythm);
        if (fabs(systole - (540 - 2.1 * rate)) > 1 || fabs(interval - 60000.0 / rate) > 1)
            fail_msg("at %u /min: systole %u ms of %u ms", rate, systole, interval);
    }
}

/* Within systole and within diastole, the advance of the phase per tick varies by at most one part in 2^20 of
 * a cycle. */
static void the_phase_is_linear_in_systole_and_in_diastole(void **state)
{
    (void)state;
    crn_rhythm rhythm;
    crn_rhythm_init(&rhythm);
    const double systole_step = CRN_PHASE_SYSTOLE_END / 393.0;
    const double diastole_step = (4294967296.0 - CRN_PHASE_SYSTOLE_END) / (857 - 393);
    for (uint32_t ms = 1; ms < 857; ms++) {
        const uint32_t before = rhythm.heart_phase32;
        crn_rhythm_step(&rhythm, &nothing);
        const double wanted = ms <= 393 ? systole_step : diastole_step;
        assert_true(fabs(rhythm.heart_phase32 - before - wanted) < 4096);
    }
}

/* The test runs 4000 beats at 75 beats a minute with a variability of 5 %. The mean interval is within 0.3 %
 * of its expected value and the standard deviation within 5 % (four standard errors are 0.3 % and 4.5 %). No
 * interval differs from the mean by more than three standard deviations, and another run gives the same
 * intervals. */
static void intervals_vary_as_stated_and_the_same_on_every_run(void **state)
{
    (void)state;
    enum { BEATS = 4000 };
    double sum = 0, squares = 0;
    crn_rhythm rhythm, again;
    crn_rhythm_init(&rhythm);
    ask(&rhythm, CRN_RHYTHM_HEART_RATE, 75);
    ask(&rhythm, CRN_RHYTHM_VARIABILITY, 50);
    again = rhythm;
    to_next_beat(&rhythm);
    to_next_beat(&again);
    for (int i = 0; i < BEATS; i++) {
        const double interval = to_next_beat(&rhythm);
        assert_true(interval == to_next_beat(&again));
        assert_true(interval >= 800 * 0.85 - 1 && interval <= 800 * 1.15 + 1);
        sum += interval;
        squares += interval * interval;
    }
    const double mean = sum / BEATS, deviation = sqrt(squares / BEATS - mean * mean);
    print_message("# mean %.2f ms, deviation %.2f ms\n", mean, deviation);
    assert_true(fabs(mean - 800) < 2.4 && fabs(deviation - 40) < 2);
}

/* A premature beat with a coupling interval of 60 % is ordered 100 ms after a QRS complex. The next QRS
 * complex comes at 60 % of the interval, and the output marks this beat as premature. The next beat after the
 * premature beat comes at the time at which the second regular beat would have come. The systole of the
 * premature beat lasts as long as the formula gives for a heart rate of 60000 / 514 beats a minute. */
static void a_premature_beat_is_followed_by_its_pause(void **state)
{
    (void)state;
    crn_rhythm rhythm;
    crn_rhythm_init(&rhythm);
    for (int ms = 1; ms < 100; ms++) crn_rhythm_step(&rhythm, &nothing);
    ask(&rhythm, CRN_RHYTHM_PREMATURE, 600);
    assert_true((rhythm.bits & CRN_RHYTHM_NEXT_PREMATURE) != 0);
    const uint32_t coupling = 100 + to_next_beat(&rhythm);
    assert_int_equal(coupling, 514);
    assert_true((rhythm.bits & CRN_RHYTHM_IS_PREMATURE) != 0);
    assert_int_equal(rhythm.systole_ms, crn_systole_ms(60000 / 514));
    assert_int_equal(coupling + to_next_beat(&rhythm), 2 * 857);
    assert_false((rhythm.bits & CRN_RHYTHM_IS_PREMATURE) != 0);
    assert_int_equal(to_next_beat(&rhythm), 857);
}

/* If the command comes late in a beat, it is too late for a premature beat in this cycle; the premature beat
 * then ends the next cycle. */
static void a_premature_beat_that_is_asked_for_too_late_comes_in_the_next_cycle(void **state)
{
    (void)state;
    crn_rhythm rhythm;
    crn_rhythm_init(&rhythm);
    for (int ms = 1; ms < 600; ms++) crn_rhythm_step(&rhythm, &nothing);
    ask(&rhythm, CRN_RHYTHM_PREMATURE, 600);
    assert_int_equal(600 + to_next_beat(&rhythm), 857);
    assert_int_equal(to_next_beat(&rhythm), 514);
    assert_true((rhythm.bits & CRN_RHYTHM_IS_PREMATURE) != 0);
}

/* After the command for asystole, the present beat ends; then the heart rests at the end of filling until a
 * command starts it again. */
static void asystole_stands_at_the_end_of_filling(void **state)
{
    (void)state;
    crn_rhythm rhythm;
    crn_rhythm_init(&rhythm);
    ask(&rhythm, CRN_RHYTHM_ASYSTOLE, 1);
    for (int ms = 1; ms < 5000; ms++) {
        crn_rhythm_step(&rhythm, &nothing);
        if (ms > 857) assert_true(rhythm.heart_phase32 == 0 && (rhythm.bits & CRN_RHYTHM_IS_RESTING) != 0);
        assert_true(crn_rhythm_is_valid(&rhythm));
    }
    assert_int_equal(rhythm.beat_ms, 5000);
    ask(&rhythm, CRN_RHYTHM_ASYSTOLE, 0);
    assert_true(rhythm.beat_count == 2 && rhythm.beat_ms == 0);
    assert_int_equal(to_next_beat(&rhythm), 857);
}

/* Fifteen breaths take a minute, within 1 ms (the increment's rounding is 3e-6); a held breath keeps its
 * phase. */
static void breath_has_its_rate_and_can_be_held(void **state)
{
    (void)state;
    crn_rhythm rhythm;
    crn_rhythm_init(&rhythm);
    ask(&rhythm, CRN_RHYTHM_BREATH_RATE, 15);
    uint32_t turns = 0, before = rhythm.breath_phase32;
    for (int ms = 1; ms < 60000; ms++) {
        crn_rhythm_step(&rhythm, &nothing);
        turns += rhythm.breath_phase32 < before;
        before = rhythm.breath_phase32;
    }
    assert_true(turns == 15 && rhythm.breath_phase32 < 2 * 15 * 71583);
    for (int ms = 0; ms < 1234; ms++) crn_rhythm_step(&rhythm, &nothing);
    const uint32_t held = rhythm.breath_phase32;
    ask(&rhythm, CRN_RHYTHM_BREATH_HOLD, 1);
    for (int ms = 0; ms < 3000; ms++) crn_rhythm_step(&rhythm, &nothing);
    assert_int_equal(rhythm.breath_phase32, held);
    ask(&rhythm, CRN_RHYTHM_BREATH_HOLD, 0);
    assert_int_equal(rhythm.breath_phase32, held + 15 * 71583);
}

static void the_depth_of_breath_is_the_fourth_power_of_a_sine(void **state)
{
    (void)state;
    double worst = 0;
    for (uint64_t phase = 0; phase < (uint64_t)1 << 32; phase += 1000003) {
        const double s = sin(acos(-1.0) * (double)phase / 4294967296.0);
        worst = fmax(worst, fabs(crn_breath_depth_q15((uint32_t)phase) - 32768 * s * s * s * s));
    }
    print_message("# off by %.3f LSB at most, allowed 1\n", worst);
    assert_true(worst <= 1);
}

static void what_is_out_of_range_is_no_order(void **state)
{
    (void)state;
    static const crn_rhythm_order wrong[] = {
        {CRN_RHYTHM_KEEP, 1},          {CRN_RHYTHM_HEART_RATE, 39},  {CRN_RHYTHM_HEART_RATE, 161},
        {CRN_RHYTHM_VARIABILITY, 101}, {CRN_RHYTHM_PREMATURE, 399},  {CRN_RHYTHM_PREMATURE, 901},
        {CRN_RHYTHM_ASYSTOLE, 2},      {CRN_RHYTHM_BREATH_RATE, 9},  {CRN_RHYTHM_BREATH_RATE, 21},
        {CRN_RHYTHM_BREATH_HOLD, 2},   {CRN_RHYTHM_ACTION_COUNT, 0}, {UINT32_MAX, UINT32_MAX},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        crn_rhythm with, without;
        crn_rhythm_init(&with);
        without = with;
        assert_false(crn_rhythm_order_is_valid(&wrong[i]));
        crn_rhythm_step(&with, &wrong[i]);
        crn_rhythm_step(&without, &nothing);
        assert_memory_equal(&with, &without, sizeof with);
    }
}

/* The test runs 200,000 ticks, with a random command in 1 of 50 ticks. The core's check of a state that is to
 * be restored must accept every state of this run, so that every snapshot of such a session can be restored.
 * The phase takes at least 2 ms from one keyframe to the next; this minimum time limits the wall's speed. */
static void whatever_is_asked_for_the_phase_has_no_jumps(void **state)
{
    (void)state;
    static const uint32_t values[CRN_RHYTHM_ACTION_COUNT][2] = {{0, 0}, {40, 160}, {0, 100}, {400, 900},
                                                                {0, 1}, {10, 20},  {0, 1}};
    reference_random random = reference_random_seed(11);
    crn_rhythm rhythm;
    uint32_t fastest = 0;
    crn_rhythm_init(&rhythm);
    for (int ms = 0; ms < 200000; ms++) {
        crn_rhythm_order order = nothing;
        if (reference_random_next(&random) % 50 == 0) {
            order.action = reference_random_next(&random) % CRN_RHYTHM_ACTION_COUNT;
            const uint32_t *range = values[order.action];
            order.value = range[0] + reference_random_next(&random) % (range[1] - range[0] + 1);
        }
        const uint32_t before = rhythm.heart_phase32;
        crn_rhythm_step(&rhythm, &order);
        const uint32_t step = rhythm.heart_phase32 - before;
        fastest = step > fastest ? step : fastest;
        assert_true(crn_rhythm_is_valid(&rhythm));
    }
    print_message("# fastest %.2f ms per keyframe, %u beats\n", 4294967296.0 / 24 / fastest,
                  rhythm.beat_count);
    assert_true(fastest < 4294967296.0 / 24 / 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(systole_follows_its_formula_and_not_the_interval),
        cmocka_unit_test(the_phase_is_linear_in_systole_and_in_diastole),
        cmocka_unit_test(intervals_vary_as_stated_and_the_same_on_every_run),
        cmocka_unit_test(a_premature_beat_is_followed_by_its_pause),
        cmocka_unit_test(a_premature_beat_that_is_asked_for_too_late_comes_in_the_next_cycle),
        cmocka_unit_test(asystole_stands_at_the_end_of_filling),
        cmocka_unit_test(breath_has_its_rate_and_can_be_held),
        cmocka_unit_test(the_depth_of_breath_is_the_fourth_power_of_a_sine),
        cmocka_unit_test(what_is_out_of_range_is_no_order),
        cmocka_unit_test(whatever_is_asked_for_the_phase_has_no_jumps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
