// Provides the wire and the hand-held carriage that both the haptic test cases and the passivity tests use.
#pragma once
#include "hil_tests/plant/plant.hpp"
#include "shared/wire/wire.h"

namespace hil
{

// Makes 350 mm of a solid wire of 0.89 mm diameter.
crn_wire_instrument haptic_wire(double bend_N_m2);
// Makes a carriage of 80 g with a damping of 1 N s/m, 20 mN of friction, and a motor with 0.5 ms of lag. A
// hand with the given stiffness in N/m and damping in N s/m holds the carriage.
PlantSettings haptic_plant(double hand_stiffness, double hand_damping);

} // namespace hil
