// Computes the steady flow through a tree by Poiseuille's law (docs/centreline.md).
#pragma once
#include "tools/centreline/tree.hpp"

namespace crn::centreline
{

struct FlowSettings {
    double inlet_mm_s = 150;      // mean speed in the inlet of each root ...
    double inlet_ml_min = 0;      // ... or, if above 0, its flow
    double pressure_mmHg = 90;    // pressure drop from the inlet to behind the beds
    double viscosity_mPa_s = 3.5; // blood
};

// Returns the flow resistance, in Pa s / mm^3, of a tube whose radius changes linearly between two spheres.
double tube_resistance(const Sphere &a, const Sphere &b, double viscosity_mPa_s);

// Sets speed_mm_s of every sphere. Returns for every branch the flow, in ml/min, just downstream of its first
// sphere. Each outlet ends in a vascular bed of flow resistance K / r^3 (Murray), where r is the outlet's
// radius and K a constant of the tree. All vascular beds have the same constant `K`. The function chooses `K`
// so that, at the given inlet flow, the beds alone cause the given pressure drop.
std::vector<double> set_flow(Tree &tree, const FlowSettings &settings);

} // namespace crn::centreline
