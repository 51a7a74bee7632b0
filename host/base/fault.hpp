// The reason why a file or an option cannot be used: one sentence with file, element and remedy. The main of
// each program prints it and exits with 1.
#pragma once
#include <stdexcept>

namespace crn
{

struct Fault : std::runtime_error {
    using std::runtime_error::runtime_error;
};

} // namespace crn
