/* Vessels of the shipped anatomies: centrelines through named stations, with the diameter of each station
 * and its source. */
#pragma once
#include "tools/anatomy/shapes.hpp"
#include <string>
#include <vector>

namespace anatomy
{

/* A point of a centreline. A point without a name only defines the course. */
struct Station {
    Vec3 position_mm;
    double diameter_mm;
    std::string name;   // "" for a point that only defines the course
    std::string source; // source of the diameter; "assumed ..." when there is none better
};

struct Vessel {
    std::string name;
    std::vector<Station> stations;
    double flow_ml_min = 0; // mean flow out of its end; 0: not stated
};

/* A vessel tree with the entry at the introducer sheath. */
struct VesselTree {
    std::string name, title;
    std::vector<Vessel> vessels;
    double fillet_mm; // width over which vessels are blended at their junctions
    Vec3 entry_position_mm, entry_direction;
    size_t coronary_count =
        0; // number of vessels at the end of the list that are joined more tightly than the others
};

VesselTree aorta_tree();
VesselTree heart_tree(); // the same with the coronary arteries
std::vector<Vessel> coronary_arteries();
bool is_right_coronary(const std::string &name); // for names of coronary_arteries()
VesselTree phantom_tree();
VesselTree access_tree(); // the phantom with a tortuous access

Curve vessel_curve(const Vessel &vessel, double step_mm);

/* Sets the entry at the introducer sheath: the farthest sample, every millimetre along the second vessel,
 * that is above `y_mm`. The instrument enters against the vessel's course. */
void put_mouth(VesselTree &tree, double y_mm);

/* Returns the blood space of the whole tree, enlarged by wall_mm. */
Solid tree_solid(const VesselTree &tree, double wall_mm);

/* The blood space of vessels that are blended over `fillet_mm` where they meet. */
Solid vessels_solid(const std::vector<Vessel> &vessels, double wall_mm, double fillet_mm);

} // namespace anatomy
