/* These tests check that the vector functions stay within the bounds stated in firmware/core/vector.h. The
 * tests compare the results with exact 128-bit integers (sums, products) and long double (lengths), on seeded
 * vectors of every magnitude and on extreme vectors. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "firmware/core/vector.h"
#include "firmware/tests/reference/exact.h"
#include "firmware/tests/reference/random.h"

enum { RANDOM_INPUTS = 1000000 };

static crn_vec3 random_vector(reference_random *random)
{
    unsigned drop = reference_random_below(random, 31);
    crn_vec3 a;
    for (int i = 0; i < 3; i++) a.v[i] = (int32_t)((int64_t)reference_random_next(random) >> 32) >> drop;
    return a;
}

/* Returns one of 27 vectors for each value of `index`; the components of these vectors are extreme or zero in
 * every combination. */
static crn_vec3 extreme_vector(unsigned index)
{
    const int32_t ends[3] = {INT32_MIN, 0, INT32_MAX};
    return crn_vec3_make(ends[index % 3], ends[index / 3 % 3], ends[index / 9 % 3]);
}

static void check_cross(crn_vec3 a, crn_vec3 b, unsigned n)
{
    crn_vec3 got = crn_vec3_cross(a, b, n);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        int k = (i + 2) % 3;
        int64_t expected = reference_saturated32(
            reference_round_shift((reference_wide)a.v[j] * b.v[k] - (reference_wide)a.v[k] * b.v[j], n));
        if (got.v[i] != expected) {
            fail_msg("component %d of (%d %d %d) x (%d %d %d) >> %u = %d, expected %lld", i, a.v[0], a.v[1],
                     a.v[2], b.v[0], b.v[1], b.v[2], n, got.v[i], (long long)expected);
        }
    }
}

static void cross_product_is_rounded_once_and_saturates(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(11);
    for (unsigned i = 0; i < 27; i++) {
        for (unsigned j = 0; j < 27; j++) {
            for (unsigned n = 1; n <= 63; n++) check_cross(extreme_vector(i), extreme_vector(j), n);
        }
    }
    for (int i = 0; i < RANDOM_INPUTS; i++) {
        crn_vec3 a = random_vector(&random);
        crn_vec3 b = random_vector(&random);
        check_cross(a, b, 1 + reference_random_below(&random, 63));
    }
}

static void sums_saturate_per_component(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 27; i++) {
        for (unsigned j = 0; j < 27; j++) {
            crn_vec3 a = extreme_vector(i);
            crn_vec3 b = extreme_vector(j);
            for (int k = 0; k < 3; k++) {
                assert_int_equal(crn_vec3_add(a, b).v[k],
                                 reference_saturated32((reference_wide)a.v[k] + b.v[k]));
                assert_int_equal(crn_vec3_sub(a, b).v[k],
                                 reference_saturated32((reference_wide)a.v[k] - b.v[k]));
            }
        }
    }
}

static void dot_product_is_exact_up_to_its_stated_range(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(12);
    const int32_t most = 1739461754; /* 2^31 * 0.81 */
    crn_vec3 a = crn_vec3_make(most, -most, most);
    assert_true(crn_vec3_dot64(a, a) == 3 * (int64_t)most * most);
    for (int i = 0; i < RANDOM_INPUTS; i++) {
        a = random_vector(&random);
        crn_vec3 b = random_vector(&random);
        for (int k = 0; k < 3; k++) b.v[k] /= 2; /* within +-2^30: the other side of the stated range */
        reference_wide expected = 0;
        for (int k = 0; k < 3; k++) expected += (reference_wide)a.v[k] * b.v[k];
        if (crn_vec3_dot64(a, b) != expected) {
            fail_msg("(%d %d %d) . (%d %d %d) = %lld, expected %lld", a.v[0], a.v[1], a.v[2], b.v[0], b.v[1],
                     b.v[2], (long long)crn_vec3_dot64(a, b), (long long)expected);
        }
    }
}

static void check_with_unit(crn_vec3 unit_q30, crn_vec3 a)
{
    reference_wide dot = 0;
    crn_vec3 cross = crn_vec3_cross_unit(&unit_q30, &a);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        int k = (i + 2) % 3;
        reference_wide minor =
            (reference_wide)unit_q30.v[j] * a.v[k] - (reference_wide)unit_q30.v[k] * a.v[j];
        dot += (reference_wide)a.v[i] * unit_q30.v[i];
        if (llabs(cross.v[i] - (long long)reference_round_shift(minor, 30)) > 4) {
            fail_msg("component %d of (%d %d %d) x (%d %d %d) = %d, expected %lld", i, unit_q30.v[0],
                     unit_q30.v[1], unit_q30.v[2], a.v[0], a.v[1], a.v[2], cross.v[i],
                     (long long)reference_round_shift(minor, 30));
        }
    }
    if (llabs(crn_vec3_dot_unit(&a, &unit_q30) - (long long)reference_round_shift(dot, 30)) > 6) {
        fail_msg("(%d %d %d) . (%d %d %d) = %d, expected %lld", a.v[0], a.v[1], a.v[2], unit_q30.v[0],
                 unit_q30.v[1], unit_q30.v[2], crn_vec3_dot_unit(&a, &unit_q30),
                 (long long)reference_round_shift(dot, 30));
    }
}

static void products_with_unit_vectors_keep_their_bounds_up_to_the_stated_length(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(14);
    const int32_t most = 2143289343; /* 2^31 (1 - 2^-9) - 1: along one axis, parallel and across */
    for (int i = 0; i < 3; i++) {
        crn_vec3 a = {{0, 0, 0}};
        a.v[i] = most;
        for (int j = 0; j < 3; j++) {
            crn_vec3 unit_q30 = {{0, 0, 0}};
            unit_q30.v[j] = CRN_ONE_Q30;
            check_with_unit(unit_q30, a);
            unit_q30.v[j] = -CRN_ONE_Q30;
            check_with_unit(unit_q30, a);
        }
    }
    for (int i = 0; i < RANDOM_INPUTS; i++) {
        crn_vec3 unit_q30 =
            crn_vec3_normalise(random_vector(&random), crn_vec3_make(CRN_ONE_Q30, 0, 0), NULL);
        crn_vec3 a = random_vector(&random);
        for (int k = 0; k < 3; k++) a.v[k] /= 2; /* length at most 2^30 sqrt(3), inside the stated one */
        check_with_unit(unit_q30, a);
    }
}

static long double worst_lsb;

static void check_normalise(crn_vec3 a)
{
    int32_t length = -1;
    crn_vec3 got = crn_vec3_normalise(a, crn_vec3_make(0, 0, CRN_ONE_Q30), &length);
    long double square = 0;
    for (int i = 0; i < 3; i++) square += (long double)a.v[i] * a.v[i];
    long double exact = sqrtl(square);
    for (int i = 0; i < 3; i++) {
        long double expected = a.v[i] / exact * 0x1p30L;
        long double off = fabsl(got.v[i] - expected);
        worst_lsb = off > worst_lsb ? off : worst_lsb;
        if (!(off <= 2.0L)) {
            fail_msg("component %d of the direction of (%d %d %d) = %d, expected %.3Lf (allowed 2 LSB)", i,
                     a.v[0], a.v[1], a.v[2], got.v[i], expected);
        }
    }
    long double clipped = exact > INT32_MAX ? INT32_MAX : exact;
    if (!(fabsl(length - clipped) <= 0.5L + exact * 0x1p-29L)) {
        fail_msg("length of (%d %d %d) = %d, expected %.3Lf", a.v[0], a.v[1], a.v[2], length, exact);
    }
}

static void directions_and_lengths_hold_for_vectors_of_any_length(void **state)
{
    (void)state;
    reference_random random = reference_random_seed(13);
    for (unsigned i = 0; i < 27; i++) {
        crn_vec3 a = extreme_vector(i);
        if (a.v[0] != 0 || a.v[1] != 0 || a.v[2] != 0) check_normalise(a);
    }
    for (int x = -8; x <= 8; x++) {
        for (int y = -8; y <= 8; y++) {
            for (int z = 1; z <= 8; z++) check_normalise(crn_vec3_make(x, y, z));
        }
    }
    for (int i = 0; i < RANDOM_INPUTS; i++) {
        crn_vec3 a = random_vector(&random);
        if (a.v[0] != 0 || a.v[1] != 0 || a.v[2] != 0) check_normalise(a);
    }
    print_message("# crn_vec3_normalise: worst error seen %.3Lf LSB\n", worst_lsb);
}

static void zero_vector_gives_the_fallback_and_length_zero(void **state)
{
    (void)state;
    int32_t length = -1;
    crn_vec3 got = crn_vec3_normalise(crn_vec3_make(0, 0, 0), crn_vec3_make(1, 2, 3), &length);
    assert_int_equal(length, 0);
    assert_int_equal(got.v[0], 1);
    assert_int_equal(got.v[1], 2);
    assert_int_equal(got.v[2], 3);
    got = crn_vec3_normalise(crn_vec3_make(0, -5, 0), got, NULL);
    assert_int_equal(got.v[1], -CRN_ONE_Q30);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sums_saturate_per_component),
        cmocka_unit_test(dot_product_is_exact_up_to_its_stated_range),
        cmocka_unit_test(cross_product_is_rounded_once_and_saturates),
        cmocka_unit_test(products_with_unit_vectors_keep_their_bounds_up_to_the_stated_length),
        cmocka_unit_test(directions_and_lengths_hold_for_vectors_of_any_length),
        cmocka_unit_test(zero_vector_gives_the_fallback_and_length_zero),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
