// Computes the pressure that an injection needs to pass through a tool's lumen, when other tools may lie in
// that lumen.
//
// Laminar flow Q of a fluid of viscosity mu through a lumen of radius R needs the pressure gradient dp/ds = 8
// mu Q / (pi R^4). A concentric guidewire of radius k R leaves an annulus with the fraction 1 - k^4 - (1 -
// k^2)^2 / ln(1/k) of the lumen's conductance (Bird, Stewart, Lightfoot, Transport Phenomena, 2.4). Beside a
// guidewire on the wall of the lumen, the conductance is at most 2.5 times that beside a concentric guidewire
// (for a narrow gap with the relative eccentricity e, 1 + 1.5 e^2 times; Snyder and Goldstein 1965). The
// functions return the least pressure that the injection can need, so that an injection is never refused
// without reason.
#pragma once
#include "host/model/instrument.hpp"
#include <span>

namespace crn
{

// The pressure limit of injectors is 1200 psi, which is also the limit of high-pressure catheters.
inline constexpr double injection_pressure_max_kPa = 8274.0;

// Returns the viscosity of iohexol at 37 degrees C, in mPa s (label of Omnipaque: 1.5, 2.0, 3.4, 6.3 and 10.4
// at 140, 180, 240, 300 and 350 mg iodine per ml). Between the strengths on the label, and down to water
// (0.69 mPa s at 0 mg/ml), the logarithm of the viscosity is linear in the strength.
double contrast_viscosity_mPa_s(double iodine_mg_per_ml);

// Describes a tool inside the lumen of an outer tool, and the distance of the inner tip behind the outer tip,
// negative if the inner tip is ahead.
struct InnerTool {
    const Instrument *tool = nullptr;
    double tip_behind_m = 0.0;
};

// Returns the pressure difference between hub and tip of `tool`, in kPa; the difference is infinite where the
// lumen is closed. `flow_ml_s` > 0.
double injection_pressure_kPa(const Instrument &tool, std::span<const InnerTool> inside, double flow_ml_s,
                              double iodine_mg_per_ml);

} // namespace crn
