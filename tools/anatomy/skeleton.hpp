/* Declares the bones of the shipped patient. Each group of bones is a Solid (shapes.hpp) in the patient
 * frame. */
#pragma once
#include "tools/anatomy/shapes.hpp"
#include <string>
#include <vector>

namespace anatomy
{

/* Holds the position and the size of one vertebra. `up` is the direction of the spine at the centre of the
 * vertebra. */
struct Vertebra {
    std::string name;
    double height_mm, width_mm, depth_mm, disc_below_mm;
    Vec3 centre_mm, up, front;
};

/* Returns the vertebrae from C5 to L5, from the top down. */
std::vector<Vertebra> vertebrae();

Solid spine_bones();    // C5-L5, sacrum, coccyx
Solid rib_bones();      // twelve pairs, sternum
Solid pelvis_bones();   // both hip bones
Solid femur_bones();    // upper thirds
Solid shoulder_bones(); // clavicles, shoulder blades, heads of the humerus; the arms are raised, as for a
                        // lateral view

} // namespace anatomy
