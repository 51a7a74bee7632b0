// A Fault states in one sentence why a scene cannot be baked: file, element and remedy. bake's main prints
// this sentence and exits with 1.
#pragma once
#include "tools/mesh/fault.hpp"

namespace crn::bake
{

using crn::Fault;

} // namespace crn::bake
