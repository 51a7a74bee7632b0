// Computes figures of a lesion for a cardiologist: how narrow and how long the lesion is, and how it affects
// the flow.
//
//   for (const LesionFigures &f : lesion_figures(tree, 3.5)) ...
//
// docs/lesions.md has the equations.
#pragma once
#include "host/effects/flow_network.hpp"
#include <string>
#include <vector>

namespace crn
{

struct LesionFigures {
    std::string name, branch;
    double length_mm = 0.0;                                        // along the healthy vessel
    double minimum_diameter_mm = 0.0, reference_diameter_mm = 0.0; // at the narrowest place: now, and healthy
    double rest_flow_ml_s = 0.0,
           rest_drop_mmHg = 0.0; // flow through the narrowest place; drop from before to behind the lesion
    double hyperaemic_flow_ml_s = 0.0, hyperaemic_drop_mmHg = 0.0;
    // Fractional flow reserve (FFR) is the pressure behind the lesion divided by the pressure in the aorta,
    // both relative to the veins, in hyperaemia.
    double ffr = 1.0;
    // Whether blood from the lesion enters beds of the heart. If not, hyperaemia changes nothing behind it,
    // and its hyperaemic figures are those of resting flow.
    bool is_coronary = false;

    double diameter_percent() const; // share of the reference that is missing
    double area_percent() const;
};

// Computes the figures of a lesion with the mean pressure and mean flows, without tools. In hyperaemia the
// heart's vascular beds are `hyperaemia_openness` times as open as at rest, and the other beds do not change.
// The coronary flow reserve of a healthy heart is 3 to 5. `opened` is the same tree after a balloon has
// widened lesions; if it is nullptr, the lesions are as narrow as in the scene file.
constexpr double hyperaemia_openness = 4.0;
std::vector<LesionFigures> lesion_figures(const VesselTree &tree, double viscosity_mPa_s,
                                          const VesselTree *opened = nullptr);

} // namespace crn
