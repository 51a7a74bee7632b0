/* Turns the lesions on the command line into [[lesion]] tables of the scene text. The program
 * `bake` makes the lesions from these [[lesion]] tables (docs/lesions.md). */
#pragma once
#include "tools/anatomy/build.hpp"

namespace anatomy
{

/* Holds the value of one option `--lesion`: BRANCH:PERCENT:LENGTH_MM:AT_MM, optionally followed by
 * `:ECCENTRICITY:PLAQUE_DEG:CALCIFIED_DEG`. The function lesion_from() throws std::invalid_argument with the
 * reason when the option's text is malformed. */
struct Lesion {
    std::string branch;
    double stenosis_percent = 0, length_mm = 0, at_mm = 0, eccentricity = 0, plaque_deg = 0,
           calcified_deg = 0;
};
Lesion lesion_from(const std::string &wish);

/* Returns the [[lesion]] tables. Throws std::invalid_argument when a lesion names a branch that the vessel
 * tree does not have. `inside` names the body in which the calcium of a lesion lies; "" means that calcium
 * lies in no body. */
std::string lesions_text(const std::vector<Lesion> &lesions, const VesselTree &tree,
                         const std::string &inside);

} // namespace anatomy
