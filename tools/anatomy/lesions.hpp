/* Lesions asked for on the command line -> [[lesion]] tables of the scene text, which `bake` makes
 * (docs/lesions.md). */
#pragma once
#include "tools/anatomy/build.hpp"

namespace anatomy
{

/* One `--lesion`: BRANCH:PERCENT:LENGTH_MM:AT_MM, then if wished :ECCENTRICITY:PLAQUE_DEG:CALCIFIED_DEG.
 * Throws std::invalid_argument with what is wrong with it. */
struct Lesion {
    std::string branch;
    double stenosis_percent = 0, length_mm = 0, at_mm = 0, eccentricity = 0, plaque_deg = 0,
           calcified_deg = 0;
};
Lesion lesion_from(const std::string &wish);

/* The tables; throws std::invalid_argument for a branch that the tree has not. Calcium lies in the body
 * called `inside`, "": in none. */
std::string lesions_text(const std::vector<Lesion> &lesions, const VesselTree &tree,
                         const std::string &inside);

} // namespace anatomy
