// The reason why a scene cannot be baked: one sentence with file, element and remedy. bake's main prints it
// and exits with 1.
#pragma once
#include "tools/mesh/fault.hpp"

namespace crn::bake
{

using crn::Fault;

} // namespace crn::bake
