/* Things of the catheter laboratory and of earlier treatment that lie on or in the patient, on request. All
 * sizes and courses are assumed. */
#pragma once
#include "tools/anatomy/soft_bodies.hpp"

namespace anatomy
{

/* Six loops of steel wire around the sternum, as after an operation of the heart. */
Solid sternal_wires();

/* The can of a pacemaker below the left clavicle, with the part of its lead that lies in veins. */
Solid pacemaker();

/* Returns the bodies of what `clutter` asks for. `bones` are those of the patient without the metal. */
std::vector<Body> clutter_bodies(const Clutter &clutter, const SoftShape &shape, const Solid &bones,
                                 double scale);

} // namespace anatomy
