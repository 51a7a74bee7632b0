// Defines the command line of `cournand rig`.
#pragma once
#include "host/rig/rig.hpp"

namespace CLI
{
class App;
}

namespace crn
{

void add_rig(CLI::App &app, RigOptions &options);

} // namespace crn
