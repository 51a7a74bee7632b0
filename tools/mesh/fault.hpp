// Declares the exception Fault, and the units in which files give lengths.
#pragma once
#include "host/base/fault.hpp"
#include <string>

namespace crn
{

// Returns the number of millimetres in a unit of length ("m", "cm", "mm", "um"), or 0 for an unknown unit.
inline double millimetres_per(const std::string &unit)
{
    if (unit == "m") return 1000.0;
    if (unit == "cm") return 10.0;
    if (unit == "mm") return 1.0;
    return unit == "um" ? 1e-3 : 0.0;
}

} // namespace crn
