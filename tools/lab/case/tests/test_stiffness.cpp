// These tests check the following. An instrument must not change if it is given its own EI of the shaft and
// its own alpha. If an instrument is given another EI of the shaft and another alpha, its EI at a point with
// the weight w is (EI of the shaft) * alpha^w. The function refuses impossible values. The EI of a knot is
// stored as a whole number of nN m^2, so the tolerance is 1 nN m^2.
#include "tools/lab/case/case.hpp"
#include "tools/lab/case/stiffness.hpp"
#include <cmath>

#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>

extern "C" {
#include <cmocka.h>
}

using namespace crn::insertion;

namespace
{

// The tip has EI 1e-5, the shaft 1e-3, and the middle their geometric mean; GJ is 0.8 of EI.
crn_wire_instrument tapered()
{
    crn_wire_instrument table{};
    for (const std::uint32_t bend : {10000u, 100000u, 1000000u}) {
        crn_wire_knot &knot = table.knots[table.knots_count];
        knot.arc_um = 100000 * table.knots_count++;
        knot.bend_stiffness_nN_m2 = bend;
        knot.twist_stiffness_nN_m2 = bend * 8 / 10;
    }
    return table;
}

void its_own_numbers_change_nothing(void **)
{
    const crn_wire_instrument table = tapered();
    const Stiffness own = stiffness_of(table);
    assert_true(std::abs(own.shaft_N_m2 - 1e-3) < 1e-12 && std::abs(own.tip_over_shaft - 0.01) < 1e-12);
    const crn_wire_instrument same = with_stiffness(table, own);
    for (unsigned i = 0; i < 3; i++) {
        assert_int_equal(same.knots[i].bend_stiffness_nN_m2, table.knots[i].bend_stiffness_nN_m2);
        assert_int_equal(same.knots[i].twist_stiffness_nN_m2, table.knots[i].twist_stiffness_nN_m2);
    }
}

void other_numbers_scale_by_the_weight_of_the_tip(void **)
{
    // For the weights w = 1, 1/2 and 0 we expect an EI of 2e-3 * 0.04^w N m^2, which is 8e-5, 4e-4 and 2e-3 N
    // m^2.
    const crn_wire_instrument other = with_stiffness(tapered(), {2e-3, 0.04});
    const std::uint32_t bend[] = {80000, 400000, 2000000};
    for (unsigned i = 0; i < 3; i++) {
        assert_in_range(other.knots[i].bend_stiffness_nN_m2, bend[i] - 1, bend[i] + 1);
        assert_in_range(other.knots[i].twist_stiffness_nN_m2, bend[i] * 8 / 10 - 1, bend[i] * 8 / 10 + 1);
    }
    assert_true(std::abs(tip_weight(1e-4, {1e-3, 0.01}) - 0.5) < 1e-12);
}

void what_the_core_does_not_take_is_held_at_its_limit(void **)
{
    assert_int_equal(with_stiffness(tapered(), {1e-3, 1e-6}).knots[0].bend_stiffness_nN_m2, 100);
    assert_int_equal(with_stiffness(tapered(), {1.0, 0.01}).knots[2].bend_stiffness_nN_m2, 30000000);
}

bool is_refused(const crn_wire_instrument &table, const Stiffness &wanted)
{
    try {
        with_stiffness(table, wanted);
    } catch (const crn::Fault &) {
        return true;
    }
    return false;
}

void numbers_that_mean_nothing_are_refused(void **)
{
    assert_true(is_refused(tapered(), {0.0, 0.1}));
    assert_true(is_refused(tapered(), {1e-3, -0.1}));
    crn_wire_instrument uniform = tapered();
    for (unsigned i = 0; i < 3; i++) uniform.knots[i].bend_stiffness_nN_m2 = 5000;
    assert_true(is_refused(uniform, {1e-3, 0.1}));
    assert_int_equal(with_stiffness(uniform, {1e-5, 1.0}).knots[1].bend_stiffness_nN_m2, 10000);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(its_own_numbers_change_nothing),
        cmocka_unit_test(other_numbers_scale_by_the_weight_of_the_tip),
        cmocka_unit_test(what_the_core_does_not_take_is_held_at_its_limit),
        cmocka_unit_test(numbers_that_mean_nothing_are_refused),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
