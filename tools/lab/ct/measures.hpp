// Two measures that several files of this room need.
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <vector>

namespace crn::ct
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

// Returns the length of a line through the points, in their unit.
inline double length_of(const std::vector<Eigen::Vector3d> &line)
{
    double length = 0;
    for (std::size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
    return length;
}

} // namespace crn::ct
