/* Vessels of the shipped anatomies: centrelines through named stations with stated diameters and where each comes from. */
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
};

VesselTree aorta_tree();
VesselTree phantom_tree();

Curve vessel_curve(const Vessel &vessel, double step_mm);

/* Blood space of the whole tree, enlarged by wall_mm. */
Solid tree_solid(const VesselTree &tree, double wall_mm);

} // namespace anatomy
