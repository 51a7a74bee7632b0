// The median of a list of numbers.
#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace crn::mesh
{

// Returns the median of the values, or 0 if there are none. Of an even number, it is the higher of the middle
// two.
inline double median(std::vector<double> values)
{
    if (values.empty()) return 0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

} // namespace crn::mesh
