/* These tests check that a processor with 256-bit registers (firmware/core/lanes.h) computes what every
 * other processor computes. The operations on lanes are compared with the operations of fixed.h on single
 * numbers, and whole sessions with lanes are compared with the same sessions without. All comparisons are
 * exact. On a processor without these registers, the tests are skipped. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "firmware/core/lanes.h"
#include "firmware/tests/reference/random.h"
#include "firmware/tests/reference/rod_rig.h"

#if CRN_HAS_LANES

static void skip_without_lanes(void)
{
    if (!crn_lanes_present()) skip();
}

/* Returns a random number of random size, or one of the ends of the range. */
static int32_t any_number(reference_random *random)
{
    const unsigned drawn = reference_random_below(random, 32);
    return drawn == 0 ? INT32_MAX : (drawn == 1 ? INT32_MIN : reference_random_scaled32(random));
}

CRN_LANES_TARGET static void check_operations(reference_random *random)
{
    int32_t a[4], b[4], back[4] = {0};
    for (int k = 0; k < 4; k++) a[k] = any_number(random), b[k] = any_number(random);
    const unsigned n = 1 + reference_random_below(random, 31);
    const int64_t most = (int64_t)1 << n;
    const crn_lanes x = crn_lanes_read(a), y = crn_lanes_read(b), product = crn_lanes_product(x, y);
    const crn_lanes shifted = crn_lanes_asr(product, n), high = crn_lanes_mulh(x, y);
    const crn_lanes limited = crn_lanes_clamp(product, most);
    for (int k = 0; k < 3; k++) {
        const int64_t exact = (int64_t)a[k] * b[k];
        assert_true(product[k] == exact);
        assert_true(shifted[k] == crn_asr64(exact, n));
        assert_true(limited[k] == (exact > most ? most : (exact < -most ? -most : exact)));
        assert_int_equal((int32_t)(crn_lanes_shift(product, n)[k]), crn_narrow64(exact, n));
        assert_int_equal((int32_t)high[k], crn_mulh(a[k], b[k]));
    }
    crn_lanes_write3(back, x);
    assert_memory_equal(back, a, 3 * sizeof *a);
    assert_int_equal(back[3], 0);
    crn_lanes_write(back, x);
    assert_memory_equal(back, a, sizeof a);
}

static void lanes_compute_what_single_numbers_compute(void **context)
{
    (void)context;
    skip_without_lanes();
    reference_random random = reference_random_seed(1);
    for (int i = 0; i < 100000; i++) check_operations(&random);
}

/* Steps two rigs that differ only in the lanes, and compares all words of their states after each tick.
 * Returns the fault bits at the end. */
static uint32_t check_session(const crn_instrument *tools, uint32_t count, const crn_lumen *lumen,
                              crn_vec3 load_N_q22, int ticks)
{
    const uint32_t inserted_um[3] = {80000, 60000, 40000};
    rig *with = rig_of(tools, count, lumen, inserted_um), *without = rig_of(tools, count, lumen, inserted_um);
    assert_true(with->model.has_lanes);
    without->model.has_lanes = false;
    crn_model_set_tip_load(&with->model, load_N_q22);
    crn_model_set_tip_load(&without->model, load_N_q22);
    reference_random random = reference_random_seed(7);
    int32_t feed_m_q30[3] = {0}, turn32[3] = {0};
    for (int tick = 0; tick < ticks; tick++) {
        for (uint32_t k = 0; k < count; k++) {
            if (tick % 200 == 0) {
                feed_m_q30[k] =
                    (int32_t)reference_random_below(&random, 400000) - 80000;   /* -0.07 .. 0.3 m/s */
                turn32[k] = (int32_t)reference_random_below(&random, 10000000); /* up to 14 rad/s */
            }
            with->input.hands[k].feed_m_q30 += feed_m_q30[k];
            with->input.hands[k].turn32 += (uint32_t)turn32[k];
        }
        without->input = with->input;
        rig_step(with);
        rig_step(without);
        if (memcmp(&with->state.words, &without->state.words, sizeof with->state.words) != 0)
            fail_msg("the states differ after tick %d", tick);
    }
    const uint32_t fault_bits = with->state.words.fault_bits;
    print_message("# %u tools, %u free nodes, fault bits %08x\n", count, with->state.words.free_count,
                  fault_bits);
    free(with);
    free(without);
    return fault_bits;
}

static void a_wire_in_a_bent_tube_moves_alike(void **context)
{
    (void)context;
    skip_without_lanes();
    reference_tube *tube = reference_three_bends(0.004, 1);
    const crn_instrument wire = reference_floppy_j(4e-4);
    check_session(&wire, 1, &tube->lumen, (crn_vec3){{0, 0, 0}}, 3000);
    reference_tube_free(tube);
}

static void three_tools_move_alike(void **context)
{
    (void)context;
    skip_without_lanes();
    reference_tube *tube = reference_three_bends(0.004, 0);
    crn_instrument tools[3];
    for (uint32_t k = 0; k < 3; k++) {
        tools[k] = reference_wire(2e-4 * (k + 1), 600000, 2000, 0.1);
        for (uint32_t i = 0; i < tools[k].knot_count; i++) {
            tools[k].knots[i].radius_outer_um = 400 + 400 * k;
            tools[k].knots[i].radius_inner_um = 400 * k;
        }
    }
    check_session(tools, 3, &tube->lumen, (crn_vec3){{0, 0, 0}}, 2000);
    reference_tube_free(tube);
}

/* A force of 100 N on a soft wire in free space reaches the limits of forces, strains and motions. */
static void values_at_their_limits_are_limited_alike(void **context)
{
    (void)context;
    skip_without_lanes();
    const crn_instrument wire = reference_wire(1e-5, 600000, 2000, 0.1);
    const int32_t most = 100 << 22;
    const uint32_t bits = check_session(&wire, 1, NULL, (crn_vec3){{-most, most, most}}, 1000);
    assert_true((bits & CRN_FAULT_SATURATED) != 0 && (bits & CRN_FAULT_STEP_CAPPED) != 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lanes_compute_what_single_numbers_compute),
        cmocka_unit_test(a_wire_in_a_bent_tube_moves_alike),
        cmocka_unit_test(three_tools_move_alike),
        cmocka_unit_test(values_at_their_limits_are_limited_alike),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#else

int main(void)
{
    return 0;
}

#endif
