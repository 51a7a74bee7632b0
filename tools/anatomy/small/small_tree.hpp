/* Makes all vessels of an anatomy that are picture and flow only: those that files state, the arteries grown
 * into heart and kidneys, and the veins of both, and the table of them that `bake` reads (docs/scene.md). */
#pragma once
#include "tools/anatomy/vessels.hpp"

namespace anatomy
{

struct SmallVessel {
    std::string name;   // of a grown vessel: a number
    std::string parent; // "": a vein that leaves the simulation
    Bed bed = Bed::body;
    bool is_vein = false;
    double flow_ul_s = 0; // out of its end; 0: not stated
    Curve points;
    std::string joins = {}; // the artery that its end passes its blood to; "": none
};

/* Returns the small vessels in an order in which each one comes after its parent. */
std::vector<SmallVessel> small_vessels_of(const VesselTree &tree);

/* Returns the courses of the arteries that are at least `diameter_mm` wide, as far as they are. Those that
 * begin behind a narrower place are left out. */
std::vector<Curve> wide_arteries(const VesselTree &tree, const std::vector<SmallVessel> &vessels,
                                 double diameter_mm);

/* Returns the table that `bake` reads. */
std::string small_vessels_text(const std::vector<SmallVessel> &vessels);

} // namespace anatomy
