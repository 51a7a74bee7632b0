// Computes how far contrast medium, which is heavier than blood, settles in a wide and slow vessel.
#pragma once
#include "host/effects/flow_cells.hpp"
#include <vector>

namespace crn
{

// Returns the mean flow through each cell at rest, ml/s: the flows of all ends behind it, averaged over three
// radii of its branch to both sides, because layers do not change at once where a branch leaves.
std::vector<double> mean_flows_ml_s(const FlowCells &cells);

// Returns the share (0 to 0.9) of the medium in a vessel that lies in the lower half of its lumen, for a mean
// concentration of iodine and a mean flow. Iohexol 350 has a density of 1.39 g/ml at 37 °C, and blood 1.055
// g/ml (docs/contrast.md, "Settling"). Settling is ruled by the Richardson number Ri = g (rho_m -
// rho_b)/rho_b d / U². Below 1/4 turbulence keeps fluids mixed (Miles 1961, Howard 1961); layers that are
// complete from 3/2 on are assumed.
double settled_share(double iodine_mg_per_ml, double radius_mm, double flow_ml_s);

} // namespace crn
