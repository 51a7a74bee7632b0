// How much blood leaves a person's own vessels, and where. Meshes close their ends in many ways, so the width
// of a vessel is taken from behind the taper of its cap.
#pragma once
#include "tools/centreline/tree.hpp"

#include <string>
#include <vector>

namespace crn::patient
{

// The mean flow out of an end of this radius: Murray's law at a wall shear rate of 500/s (flow ~ r^3), as
// everywhere in the model, but at a mean speed of at most 160 mm/s (flow ~ r^2). Those are 5 l/min in an
// ascending aorta of 26 mm diameter. Murray's law alone would give an aorta 40 l/min.
double outlet_flow_ml_s(double radius_mm);

// Widens the spheres in the tapers before the caps, at the inlet and at every end: they would stop the blood.
void open_ends(centreline::Tree &tree);

// An end where blood leaves, in the tree that `bake` makes of the branches.
struct Outflow {
    std::string branch;
    double radius_mm = 0, flow_ml_s = 0;
};
std::vector<Outflow> outflows(const centreline::Tree &tree);

double sum_ml_s(const std::vector<Outflow> &flows);
// The table [tree.flow_ml_min] of a scene; it ends the table [tree].
std::string scene_text(const std::vector<Outflow> &flows);

} // namespace crn::patient
