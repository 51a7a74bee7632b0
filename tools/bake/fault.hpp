// A Fault states in one sentence why a scene cannot be baked, and names the file, the element and the remedy.
// The main function of `bake` prints the sentence of a Fault and exits with 1.
#pragma once
#include "tools/mesh/fault.hpp"

namespace crn::bake
{

using crn::Fault;

} // namespace crn::bake
