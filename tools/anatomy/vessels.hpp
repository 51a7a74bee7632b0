/* Vessels of the shipped anatomies: centrelines through named stations with stated diameters and where each
 * comes from. */
#pragma once
#include "tools/anatomy/shapes.hpp"
#include <string>
#include <vector>

namespace anatomy
{

/* A point of a centreline. Points without a name only give the course. */
struct Station {
    Vec3 position_mm;
    double diameter_mm;
    std::string name;   // "" for a point of the course
    std::string source; // where the diameter comes from; "assumed ..." when from nowhere better
};

struct Vessel {
    std::string name;
    std::vector<Station> stations;
    double flow_ml_min = 0; // mean, out of its end; 0: not stated
};

/* A vessel tree with the mouth of the inserter sheath. */
struct VesselTree {
    std::string name, title;
    std::vector<Vessel> vessels;
    double fillet_mm; // width over which vessels are blended at their junctions
    Vec3 entry_position_mm, entry_direction;
    size_t coronary_count = 0; // the last so many vessels: joined more tightly than the others
};

VesselTree aorta_tree();
VesselTree heart_tree(); // the same with the coronary arteries
std::vector<Vessel> coronary_arteries();
bool is_right_coronary(const std::string &name); // of coronary_arteries()
VesselTree phantom_tree();
VesselTree access_tree(); // the phantom with a winding access

Curve vessel_curve(const Vessel &vessel, double step_mm);

/* The mouth of the sheath: the farthest sample, every millimetre along the second vessel, that is above
 * `y_mm`; it enters against the vessel's course. */
void put_mouth(VesselTree &tree, double y_mm);

/* Blood space of the whole tree, enlarged by wall_mm. */
Solid tree_solid(const VesselTree &tree, double wall_mm);

/* Blood space of vessels that are blended over `fillet_mm` where they meet. */
Solid vessels_solid(const std::vector<Vessel> &vessels, double wall_mm, double fillet_mm);

} // namespace anatomy
