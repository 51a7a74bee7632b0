// A Fault states in one sentence why a file or an option cannot be used: file, element and remedy. The main
// function of each program prints this sentence and exits with 1.
#pragma once
#include <stdexcept>

namespace crn
{

struct Fault : std::runtime_error {
    using std::runtime_error::runtime_error;
};

} // namespace crn
