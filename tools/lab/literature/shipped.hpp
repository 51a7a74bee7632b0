// Brings shipped instruments into the validation's rig.
#pragma once
#include "tools/lab/validate/rig.hpp"

#include <string>

namespace crn::literature
{

// Returns the first `length_m` of a shipped instrument, without its shape, with elements of one length.
validate::Tool shipped_tool(const std::string &name, double length_m, double element_m);

// Returns the bending stiffness of the shaft, which is that of the last knot.
double shaft_bend_N_m2(const std::string &name);

} // namespace crn::literature
