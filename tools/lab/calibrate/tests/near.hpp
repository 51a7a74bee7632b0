// A comparison for the tests of calibration, and the folder of the shipped instruments.
#pragma once
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
extern "C" {
#include <cmocka.h>
}

namespace crn::calibrate::tests
{

constexpr const char *instruments = "shared/examples/instruments/";

// Fails unless `got` differs from `expected` by at most `tolerance`.
inline void assert_near(double got, double expected, double tolerance)
{
    if (std::abs(got - expected) <= tolerance) return;
    print_error("got %.9g, expected %.9g within %.2g\n", got, expected, tolerance);
    assert_true(false);
}

} // namespace crn::calibrate::tests
