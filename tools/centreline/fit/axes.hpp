// The axes of a mesh or a tree, as the option --axes names them.
#pragma once
#include <Eigen/Core>
#include <string>

namespace crn::centreline
{

// A text such as "+x,+z,-y" gives, for each axis of the output, the corresponding axis of the file and its
// sign. Throws UsageError, whose message ends with `also`: what else the option may be.
Eigen::Matrix3d turned_axes(const std::string &text, const std::string &also = "");

} // namespace crn::centreline
