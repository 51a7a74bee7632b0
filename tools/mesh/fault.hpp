// The reason why a file or an option cannot be used: one sentence with file, element and remedy. The tools'
// main prints it and exits with 1.
#pragma once
#include <stdexcept>
#include <string>

namespace crn
{

struct Fault : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// Returns the millimetres per unit ("m", "cm", "mm", "um"); 0 for an unknown unit.
inline double millimetres_per(const std::string &unit)
{
    if (unit == "m") return 1000.0;
    if (unit == "cm") return 10.0;
    if (unit == "mm") return 1.0;
    return unit == "um" ? 1e-3 : 0.0;
}

} // namespace crn
