// Tests the prefilter of the heartbeat's spline against the equation that its coefficients solve, and the
// filter of six sequences against that of one.
#include "host/model/motion.hpp"
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
extern "C" {
#include <cmocka.h>
}

namespace
{

// Six ways in um of a heart that moves by millimetres, with other harmonics in each.
crn::MotionWays sample_ways()
{
    crn::MotionWays w;
    for (int key = 0; key < crn::motion_keyframes; ++key)
        for (int way = 0; way < crn::motion_ways; ++way)
            w[key][way] = 4000.0 * std::sin(0.2618 * key * (way + 1) + way) - 700.0 * way;
    return w;
}

void coefficients_solve_the_equation_of_the_spline(void **)
{
    const crn::MotionWays w = sample_ways(), c = crn::motion_prefilter(w);
    constexpr int n = crn::motion_keyframes;
    for (int key = 0; key < n; ++key)
        for (int way = 0; way < crn::motion_ways; ++way) {
            const double sum = c[(key + n - 1) % n][way] + 6 * c[key][way] + c[(key + 1) % n][way];
            assert_float_equal(sum / 8, w[key][way], 1e-6); // um
        }
}

void six_ways_get_the_bits_of_single_ones(void **)
{
    const crn::MotionWays w = sample_ways(), c = crn::motion_prefilter(w);
    for (int way = 0; way < crn::motion_ways; ++way) {
        double one[crn::motion_keyframes], alone[crn::motion_keyframes];
        for (int key = 0; key < crn::motion_keyframes; ++key) one[key] = w[key][way];
        crn::motion_prefilter(one, alone);
        for (int key = 0; key < crn::motion_keyframes; ++key)
            assert_memory_equal(&alone[key], &c[key][way], sizeof(double));
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(coefficients_solve_the_equation_of_the_spline),
        cmocka_unit_test(six_ways_get_the_bits_of_single_ones),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
