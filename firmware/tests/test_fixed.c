/* These tests check that every operation of firmware/core/fixed.h stays within the error that its comment
 * states. The tests compare the results with 128-bit integers where these are exact, and otherwise with long
 * double (64-bit mantissa, libm error < 2^-62 relative). The inputs are millions of seeded values and the
 * limits of each range. The seed is fixed: a failure prints its inputs, and running the program again
 * reproduces it. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "firmware/core/fixed.h"
#include "firmware/tests/reference/exact.h"
#include "firmware/tests/reference/random.h"

enum { RANDOM_INPUTS = 2000000 };

static const int32_t border32[] = {
    INT32_MIN,
    INT32_MIN + 1,
    -(1 << 30) - 1,
    -(1 << 30),
    -(1 << 30) + 1,
    -65536,
    -3,
    -2,
    -1,
    0,
    1,
    2,
    3,
    65535,
    65536,
    (1 << 30) - 1,
    1 << 30,
    (1 << 30) + 1,
    INT32_MAX - 1,
    INT32_MAX,
};
enum { BORDERS = sizeof(border32) / sizeof(border32[0]) };

static void expect_equal(const char *name, int64_t a, int64_t b, unsigned n, int64_t got, int64_t expected)
{
    if (got != expected) {
        fail_msg("%s(%lld, %lld, n = %u) = %lld, expected %lld", name, (long long)a, (long long)b, n,
                 (long long)got, (long long)expected);
    }
}

static void expect_near(const char *name, int64_t input, int64_t got, long double expected,
                        long double bound_lsb)
{
    long double off = (long double)got - expected;
    if (!(fabsl(off) <= bound_lsb)) {
        fail_msg("%s(%lld) = %lld, expected %.3Lf (off by %.3Lf LSB, allowed %.3Lf)", name, (long long)input,
                 (long long)got, expected, off, bound_lsb);
    }
}

/* The inputs have the range that the comment of crn_scale_q30 requires: |a| < 2^31 (1 - 2^-9), |b| <= 1 +
 * 2^-10. */
static const int32_t scale_limit = 2143289344;
static const int32_t scale_factor_max = (1 << 30) + (1 << 20);

static void check_pair(int32_t a, int32_t b, unsigned n)
{
    reference_wide product = (reference_wide)a * b;
    expect_equal("crn_mul", a, b, n, crn_mul(a, b, n),
                 reference_saturated32(reference_round_shift(product, n)));
    expect_equal("crn_mulh", a, b, 32, crn_mulh(a, b), (int64_t)reference_round_shift(product, 32));
    expect_equal("crn_mul_q30", a, b, 30, crn_mul_q30(a, b),
                 reference_saturated32(reference_round_shift(product, 30)));
    if (a > -scale_limit && a < scale_limit && b >= -scale_factor_max && b <= scale_factor_max) {
        expect_equal("crn_scale_q30", a, b, 30, crn_scale_q30(a, b),
                     (int64_t)reference_round_shift(product, 32) * 4);
    }
    int64_t sum = (int64_t)reference_round_shift(product, 32) + n;
    expect_equal("crn_mulh_add", a, b, n, crn_mulh_add((int32_t)n, a, b), sum);
    int64_t wide = (int64_t)a * b;
    expect_equal("crn_high64", a, b, 32, crn_high64(wide), (int64_t)reference_floor_shift(product, 32));
    reference_wide floor = reference_floor_shift(product, n);
    if (n <= 31 && floor == reference_saturated32(floor)) {
        expect_equal("crn_narrow64", a, b, n, crn_narrow64(wide, n), (int64_t)floor);
    }
    expect_equal("crn_add_sat", a, b, 0, crn_add_sat(a, b), reference_saturated32((reference_wide)a + b));
    expect_equal("crn_sub_sat", a, b, 0, crn_sub_sat(a, b), reference_saturated32((reference_wide)a - b));
}

static void products_and_sums_are_exact_rounded_once_and_saturate(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(1);
    for (unsigned i = 0; i < BORDERS; i++) {
        for (unsigned j = 0; j < BORDERS; j++) {
            for (unsigned n = 1; n <= 62; n++) check_pair(border32[i], border32[j], n);
        }
    }
    for (int i = 0; i < RANDOM_INPUTS; i++) {
        int32_t a = reference_random_scaled32(&random);
        int32_t b = reference_random_scaled32(&random);
        check_pair(a, b, 1 + reference_random_below(&random, 62));
    }
}

static void ties_round_towards_plus_infinity(void **state)
{
    (void)state;
    assert_int_equal(crn_rshift_round64(3, 1), 2);
    assert_int_equal(crn_rshift_round64(-3, 1), -1);
    assert_int_equal(crn_rshift_round64(1, 1), 1);
    assert_int_equal(crn_rshift_round64(-1, 1), 0);
    assert_int_equal(crn_mulh(1 << 16, 1 << 15), 1);
    assert_int_equal(crn_mulh(-(1 << 16), 1 << 15), 0);
    assert_int_equal(crn_mulh(-(1 << 16), (1 << 15) + 1), -1);
}

static void shifts_are_floor_and_rounded_over_64_bits(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(2);
    assert_int_equal(crn_asr64(INT64_MIN, 63), -1);
    assert_int_equal(crn_asr64(-1, 63), -1);
    assert_int_equal(crn_asr64(INT64_MAX, 0), INT64_MAX);
    for (int i = 0; i < RANDOM_INPUTS; i++) {
        int64_t a = (int64_t)reference_random_next(&random) >> reference_random_below(&random, 63);
        unsigned n = reference_random_below(&random, 64);
        expect_equal("crn_asr64", a, 0, n, crn_asr64(a, n), (int64_t)reference_floor_shift(a, n));
        n = 1 + n % 62;
        int64_t bound = INT64_MAX - ((int64_t)1 << (n - 1));
        if (a <= bound) {
            expect_equal("crn_rshift_round64", a, 0, n, crn_rshift_round64(a, n),
                         (int64_t)reference_round_shift(a, n));
        }
    }
}

static void saturation_holds_on_both_sides_of_both_borders(void **state)
{
    (void)state;
    const int64_t top = INT32_MAX;
    const int64_t bottom = INT32_MIN;
    for (int64_t step = -2; step <= 2; step++) {
        expect_equal("crn_sat32", top + step, 0, 0, crn_sat32(top + step), reference_saturated32(top + step));
        expect_equal("crn_sat32", bottom + step, 0, 0, crn_sat32(bottom + step),
                     reference_saturated32(bottom + step));
    }
    assert_int_equal(crn_sat32(INT64_MAX), INT32_MAX);
    assert_int_equal(crn_sat32(INT64_MIN), INT32_MIN);
}

static void leading_zeros_are_counted_for_every_bit_and_for_zero(void **state)
{
    (void)state;
    assert_int_equal(crn_clz32(0), 32);
    assert_int_equal(crn_clz64(0), 64);
    for (unsigned bit = 0; bit < 64; bit++) {
        uint64_t lowest = (uint64_t)1 << bit;
        uint64_t filled = lowest | (lowest - 1);
        assert_int_equal(crn_clz64(lowest), 63 - bit);
        assert_int_equal(crn_clz64(filled), 63 - bit);
        if (bit < 32) {
            assert_int_equal(crn_clz32((uint32_t)lowest), 31 - bit);
            assert_int_equal(crn_clz32((uint32_t)filled), 31 - bit);
        }
    }
}

static long double worst_seen;

static void check_worst(const char *name, int64_t input, int64_t got, long double expected,
                        long double bound_lsb)
{
    long double clipped = expected > INT32_MAX ? INT32_MAX : expected;
    long double off = fabsl((long double)got - clipped);
    worst_seen = off > worst_seen ? off : worst_seen;
    expect_near(name, input, got, clipped, bound_lsb);
}

static void report_worst(const char *name)
{
    print_message("# %s: worst error seen %.3Lf LSB\n", name, worst_seen);
    worst_seen = 0;
}

static void check_reciprocal(uint32_t m)
{
    check_worst("crn_reciprocal_q30", m, crn_reciprocal_q30(m), 0x1p61L / m, 1.0L);
}

static void reciprocal_is_within_one_lsb(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(3);
    assert_int_equal(crn_reciprocal_q30(1u << 30), INT32_MAX);
    /* both sides of all 128 intervals of the table, their middles, and the largest input */
    for (uint32_t row = 128; row < 256; row++) {
        for (int32_t step = -64; step < 64; step++) {
            uint32_t m = (row << 23) + (uint32_t)step;
            if (m >= 1u << 30) check_reciprocal(m);
            check_reciprocal((row << 23) + (1u << 22) + (uint32_t)step);
        }
    }
    check_reciprocal(INT32_MAX);
    for (int i = 0; i < 2 * RANDOM_INPUTS; i++) {
        check_reciprocal((1u << 30) | (uint32_t)(reference_random_next(&random) >> 34));
    }
    report_worst("crn_reciprocal_q30");
}

static void check_rsqrt(uint32_t m)
{
    check_worst("crn_rsqrt_q30", m, crn_rsqrt_q30(m), 0x1p46L / sqrtl(m), 1.5L);
}

static void reciprocal_square_root_is_within_one_and_a_half_lsb(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(4);
    assert_int_equal(crn_rsqrt_q30(1u << 30), INT32_MAX);
    for (uint32_t row = 64; row < 256; row++) {
        for (int32_t step = -64; step < 64; step++) {
            uint32_t m = (row << 24) + (uint32_t)step;
            if (m >= 1u << 30) check_rsqrt(m);
            check_rsqrt((row << 24) + (1u << 23) + (uint32_t)step);
        }
    }
    check_rsqrt(UINT32_MAX);
    for (int i = 0; i < 2 * RANDOM_INPUTS; i++) {
        uint32_t m = (uint32_t)(reference_random_next(&random) >> 32);
        check_rsqrt(m < 1u << 30 ? m | 1u << 30 : m);
    }
    report_worst("crn_rsqrt_q30");
}

static void check_sqrt(uint64_t a)
{
    long double root = sqrtl((long double)a);
    int32_t got = crn_sqrt64(a);
    long double clipped = root > INT32_MAX ? INT32_MAX : root;
    if (!(fabsl((long double)got - clipped) <= 0.5L + root * 0x1p-29L)) {
        fail_msg("crn_sqrt64(%llu) = %d, expected %.3Lf", (unsigned long long)a, got, root);
    }
}

static void square_root_is_right_from_zero_to_saturation(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(5);
    assert_int_equal(crn_sqrt64(0), 0);
    assert_int_equal(crn_sqrt64(1), 1);
    assert_int_equal(crn_sqrt64(UINT64_MAX), INT32_MAX);
    for (uint64_t a = 0; a < 200000; a++) check_sqrt(a);
    for (unsigned bit = 0; bit < 64; bit++) {
        check_sqrt((uint64_t)1 << bit);
        check_sqrt(((uint64_t)1 << bit) - 1);
        check_sqrt(((uint64_t)1 << bit) + 1);
    }
    for (int i = 0; i < RANDOM_INPUTS; i++) {
        check_sqrt(reference_random_next(&random) >> reference_random_below(&random, 64));
    }
}

static void check_divide(uint64_t a, uint64_t b)
{
    uint64_t got = crn_divide_u64(a, b);
    uint64_t expected = b == 0 ? UINT64_MAX : a / b;
    if (got != expected) {
        fail_msg("crn_divide_u64(%llu, %llu) = %llu, expected %llu", (unsigned long long)a,
                 (unsigned long long)b, (unsigned long long)got, (unsigned long long)expected);
    }
}

static void set_up_division_is_exact_also_for_divisors_above_2_63(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(6);
    const uint64_t borders[] = {
        0, 1, 2, 3, INT64_MAX, (uint64_t)1 << 63, UINT64_MAX, UINT64_MAX - 1, UINT32_MAX, 1ull << 32};
    for (unsigned i = 0; i < sizeof(borders) / sizeof(borders[0]); i++) {
        for (unsigned j = 0; j < sizeof(borders) / sizeof(borders[0]); j++)
            check_divide(borders[i], borders[j]);
    }
    for (int i = 0; i < RANDOM_INPUTS / 4; i++) {
        check_divide(reference_random_next(&random) >> reference_random_below(&random, 64),
                     reference_random_next(&random) >> reference_random_below(&random, 64));
    }
}

static void check_sincos(uint32_t angle)
{
    int32_t sine = 0;
    int32_t cosine = 0;
    long double radians = (long double)angle * 0x1p-31L * acosl(-1.0L);
    crn_sincos_turn32(angle, &sine, &cosine);
    check_worst("sin of crn_sincos_turn32", angle, sine, sinl(radians) * 0x1p30L, 1.5L);
    check_worst("cos of crn_sincos_turn32", angle, cosine, cosl(radians) * 0x1p30L, 1.5L);
    if (sine > CRN_ONE_Q30 || sine < -CRN_ONE_Q30 || cosine > CRN_ONE_Q30 || cosine < -CRN_ONE_Q30) {
        fail_msg("sin, cos of %u = %d, %d: beyond +-2^30", angle, sine, cosine);
    }
}

static void sine_and_cosine_are_within_one_and_a_half_lsb_all_around(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(7);
    for (uint32_t eighth = 0; eighth < 8; eighth++) {
        for (int32_t step = -64; step <= 64; step++) check_sincos((eighth << 29) + (uint32_t)step);
    }
    for (int i = 0; i < RANDOM_INPUTS / 2; i++)
        check_sincos((uint32_t)(reference_random_next(&random) >> 32));
    report_worst("crn_sincos_turn32");
}

static void check_asin(int32_t a)
{
    long double clipped = a > CRN_ONE_Q30 ? 1.0L : a < -CRN_ONE_Q30 ? -1.0L : (long double)a * 0x1p-30L;
    check_worst("crn_asin_q29", a, crn_asin_q29(a), asinl(clipped) * 0x1p29L, 1.5L);
}

static void arc_sine_is_within_one_and_a_half_lsb_and_clamps_beyond_one(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(8);
    for (unsigned i = 0; i < BORDERS; i++) check_asin(border32[i]);
    for (int32_t step = -4096; step <= 4096; step++) {
        check_asin(step);
        check_asin((CRN_ONE_Q30 >> 1) + step); /* where the half-angle identity takes over */
        check_asin(-(CRN_ONE_Q30 >> 1) + step);
        check_asin(CRN_ONE_Q30 + step);
        check_asin(-CRN_ONE_Q30 + step);
    }
    for (int i = 0; i < RANDOM_INPUTS / 2; i++)
        check_asin((int32_t)(reference_random_next(&random) >> 33) - (1 << 30));
    report_worst("crn_asin_q29");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(products_and_sums_are_exact_rounded_once_and_saturate),
        cmocka_unit_test(ties_round_towards_plus_infinity),
        cmocka_unit_test(shifts_are_floor_and_rounded_over_64_bits),
        cmocka_unit_test(saturation_holds_on_both_sides_of_both_borders),
        cmocka_unit_test(leading_zeros_are_counted_for_every_bit_and_for_zero),
        cmocka_unit_test(reciprocal_is_within_one_lsb),
        cmocka_unit_test(reciprocal_square_root_is_within_one_and_a_half_lsb),
        cmocka_unit_test(square_root_is_right_from_zero_to_saturation),
        cmocka_unit_test(set_up_division_is_exact_also_for_divisors_above_2_63),
        cmocka_unit_test(sine_and_cosine_are_within_one_and_a_half_lsb_all_around),
        cmocka_unit_test(arc_sine_is_within_one_and_a_half_lsb_and_clamps_beyond_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
