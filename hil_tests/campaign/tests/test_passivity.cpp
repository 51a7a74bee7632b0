// This test runs a selection of the grid of force gain, coupling stiffness, damping, motor lag and grip of
// the hand (make hil-passivity runs the whole grid). With every combination of settings that the device
// accepts, the carriage must stay below the speed limit and must not oscillate permanently. The test also
// checks CycleMeter, the class that measures oscillations of the motor force.
#include "hil_tests/campaign/passivity.hpp"
#include "hil_tests/l0/sim_bench.hpp"
#include <cmath>
#include <csetjmp>
#include <cstdarg>

extern "C" {
#include <cmocka.h>
}

namespace
{

void nothing_that_is_accepted_is_fast_or_goes_on_to_and_fro(void **)
{
    hil::SimLevel level;
    assert_true(hil::passivity_grid().size() >= 300);
    assert_int_equal(hil::run_passivity_grid(level, 41, ""), 0);
}

// The device must refuse a coupling of 800 N/m at a force gain of 2, even if the host declares the rig's true
// damping. With a coupling of 800 N/m at a force gain of 2, a carriage in a loose hand reached 0.34 m/s.
void a_gain_of_two_on_honest_damping_is_refused(void **)
{
    hil::SimLevel level;
    assert_true(hil::run_passivity(level, {1000, 800, 1000, 500, false}).is_accepted);
    assert_false(hil::run_passivity(level, {2000, 800, 1000, 500, false}).is_accepted);
}

// CycleMeter must count a sine of 20 Hz that lasts 250 ms as an oscillation if its amplitude is 60 mN, but
// not if its amplitude is 40 mN. It must not count a step of the force.
void the_meter_measures_cycles(void **)
{
    hil::CycleMeter felt(0.1), unfelt(0.1), step(0.1);
    for (int ms = 0; ms < 250; ms++) {
        felt.take(0.060 * std::sin(ms * 0.1257));
        unfelt.take(0.040 * std::sin(ms * 0.1257));
        step.take(ms < 100 ? 0.0 : 2.0);
    }
    assert_true(felt.longest_ms() > 180.0 && felt.longest_ms() <= 250.0);
    assert_true(std::abs(felt.largest_N() - 0.060) < 0.002);
    assert_true(unfelt.longest_ms() == 0.0 && step.longest_ms() == 0.0);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        {"the_meter_measures_cycles", the_meter_measures_cycles, nullptr, nullptr, nullptr},
        {"a_gain_of_two_on_honest_damping_is_refused", a_gain_of_two_on_honest_damping_is_refused, nullptr,
         nullptr, nullptr},
        {"nothing_that_is_accepted_is_fast_or_goes_on_to_and_fro",
         nothing_that_is_accepted_is_fast_or_goes_on_to_and_fro, nullptr, nullptr, nullptr},
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
