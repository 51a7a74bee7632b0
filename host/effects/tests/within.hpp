// A comparison for tests of flow, with a text that states what differs.
#pragma once
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
extern "C" {
#include <cmocka.h>
}

namespace crn::tests
{

// Fails unless `value` differs from `expected` by at most the share `tolerance` of it.
inline void within(const char *what, double value, double expected, double tolerance)
{
    if (std::fabs(value - expected) <= tolerance * std::fabs(expected)) return;
    fail_msg("%s = %.9g, expected %.9g (allowed %.3g %%)", what, value, expected, tolerance * 100);
}

} // namespace crn::tests
