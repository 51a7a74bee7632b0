// Holds the permitted range of a number.
#pragma once

namespace crn
{

struct NumberRange {
    double low = 0.0, high = 0.0;
    bool contains(double value) const { return value >= low && value <= high; } // false for NaN
};

} // namespace crn
