// Measures that several files of this room need.
#pragma once
#include "tools/mesh/median.hpp"
#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace crn::ct
{

using mesh::median;

// Returns the length of a line through the points, in their unit.
inline double length_of(const std::vector<Eigen::Vector3d> &line)
{
    double length = 0;
    for (std::size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
    return length;
}

} // namespace crn::ct
