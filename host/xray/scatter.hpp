// Scattered photons, by convolution of the primary picture.
//
// Each place of the detector is the middle of a broad patch of scatter whose sum is in proportion to P
// ln(1/P), P the primary transmission there: photons lost on the way times those that still come through
// (Ohnesorge, Flohr and Klingenbeck-Regn, Eur. Radiol. 9 (1999) 563):
//
//     S = 0.70 [P ln(1/P)] * G,   G: Gaussian of 60 mm standard deviation at the detector, of sum 1
//
// So the ratio S/P rises with thickness, rises with the field's size up to about 25 cm, and fills dark places
// from bright ones. The factor is set by one measurement: 30 cm of acrylic in a field of 40 x 30 cm
// scatters 4.51 times the primary, and 1.28 times behind a grid of ratio 10 that lets 70.6 % of the primary
// and 21 % of the scattered photons through (Altunbas et al., Med. Phys. 43 (2016), abstract WE-AB-207A-10).
// The air gap's own part is in that figure and not varied.
#pragma once
#include "host/xray/coarse.hpp"

namespace crn
{

// Share of scattered photons that the grid lets through, over that of primary ones.
inline constexpr float grid_scatter_to_primary = 0.21f / 0.706f;

// Scatter in each cell of the coarse grid, in the units of the primary sums (1: the open beam), in front of a
// grid.
std::vector<float> scatter_part(const CoarseSums &primary, int cells, double cell_mm);

} // namespace crn
