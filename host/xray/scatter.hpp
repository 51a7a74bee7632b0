// Scattered photons are computed by convolution of the picture of primary (unscattered) photons.
//
// From each point of the detector, scattered photons are spread over a broad area around the point. The
// number of photons scattered from a point is proportional to P ln(1/P), where P is the transmission of
// primary photons at that point. P ln(1/P) is the fraction lost in the patient, ln(1/P), times the fraction
// still transmitted, P (Ohnesorge, Flohr and Klingenbeck-Regn, Eur Radiol 9 (1999) 563).
//
//     S = 0.70 [P ln(1/P)] * G,   G: Gaussian of 60 mm standard deviation at the detector, of sum 1
//
// By this formula the ratio S/P of scattered to primary photons rises with the patient's thickness, and with
// the size of the field up to about 25 cm. Photons scattered from bright areas brighten dark areas. The
// factor of 0.70 is set by one measurement: 30 cm of acrylic in a field of 40 x 30 cm scatter 4.51 times the
// primary photons. Behind a grid of ratio 10 the measured ratio S/P is 1.28; that grid transmits 70.6 % of
// the primary and 21 % of the scattered photons (Altunbas et al., Med Phys 43 (2016), abstract
// WE-AB-207A-10). The measured ratio S/P includes the effect of the air gap between patient and detector,
// which is constant in this model.
#pragma once
#include "host/xray/coarse.hpp"

namespace crn
{

// Gives the fraction of scattered photons that the anti-scatter grid transmits, divided by the fraction of
// primary photons.
inline constexpr float grid_scatter_to_primary = 0.21f / 0.706f;
inline constexpr float scatter_per_neper =
    0.70f; // in front of the grid, behind plates wider than the Gaussian

// Spreads what each cell of the coarse grid scatters by the Gaussian G; the cells outside of the grid scatter
// nothing.
void spread_scatter(std::vector<float> &grid, int cells, double cell_mm);

// Returns the scattered signal in each cell of the coarse grid in front of the anti-scatter grid, in the
// units of the primary sums (1 is the open beam).
std::vector<float> scatter_part(const CoarseSums &primary, int cells, double cell_mm);

} // namespace crn
