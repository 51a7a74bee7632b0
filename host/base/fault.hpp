// A Fault says in one sentence why a file or an option cannot be used: it names the file, the element and the
// remedy. The main function of each program prints the sentence of a Fault and exits with 1.
#pragma once
#include <stdexcept>

namespace crn
{

struct Fault : std::runtime_error {
    using std::runtime_error::runtime_error;
};

} // namespace crn
