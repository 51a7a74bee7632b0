// Scattered photons are computed by convolution of the primary picture.
//
// Each place of the detector is the middle of a broad patch of scatter. The patch's sum is in proportion to P
// ln(1/P), where P is the primary transmission there: the share of photons lost in the patient times the
// share still transmitted (Ohnesorge, Flohr and Klingenbeck-Regn, Eur. Radiol. 9 (1999) 563):
//
//     S = 0.70 [P ln(1/P)] * G,   G: Gaussian of 60 mm standard deviation at the detector, of sum 1
//
// So the ratio S/P rises with thickness and with the field's size up to about 25 cm, and scatter from bright
// places fills dark ones. One measurement sets the factor: 30 cm of acrylic in a field of 40 x 30 cm scatters
// 4.51 times the primary. Behind a grid of ratio 10 it is 1.28 times; that grid transmits 70.6 % of the
// primary and 21 % of the scattered photons (Altunbas et al., Med. Phys. 43 (2016), abstract WE-AB-207A-10).
// That figure includes the effect of the air gap, which is not varied.
#pragma once
#include "host/xray/coarse.hpp"

namespace crn
{

// The grid's transmission of scattered photons over that of primary ones.
inline constexpr float grid_scatter_to_primary = 0.21f / 0.706f;

// Returns the scatter in each cell of the coarse grid in front of a grid, in the units of the primary sums
// (1: the open beam).
std::vector<float> scatter_part(const CoarseSums &primary, int cells, double cell_mm);

} // namespace crn
