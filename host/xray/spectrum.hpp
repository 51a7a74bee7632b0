// Computes the output of the X-ray tube: the photons at each energy, for any tube voltage and filter.
//
// The model is that of Tucker, Barnes and Chakraborty, "Semiempirical model for generating tungsten target
// x-ray spectra", Med Phys 18 (1991) 402. Electrons slow down in the anode (Thomson-Whiddington) and make
// bremsstrahlung and K lines, which are attenuated by the tungsten above them. The anode angle of the
// modelled tube is 11 degrees. One factor scales the tube's output to the kerma that spekpy 2.5.4 gives at 80
// kV behind 2.5 mm Al + 0.2 mm Cu. The computation uses no libm, so that every compiler gives the same table.
#pragma once
#include "host/xray/attenuation.hpp"
#include <array>

namespace crn
{

inline constexpr double tube_voltage_min_kV = 40.0, tube_voltage_max_kV = 125.0;
inline constexpr double inherent_aluminium_mm = 2.5; // glass, oil and window of the tube, as aluminium

// Holds the photons per mm2 and mAs at 1 m from the focal spot, in each step of 1 keV (energy_keV).
using Spectrum = std::array<double, energy_count>;

// Returns the spectrum behind the inherent filter and `copper_mm` of copper. The voltage is limited to the
// range from tube_voltage_min_kV to tube_voltage_max_kV.
Spectrum tube_spectrum(double tube_voltage_kV, double copper_mm);

// Returns the spectrum behind `thickness_cm` of a material.
Spectrum behind(const Spectrum &spectrum, Material material, double thickness_cm);

// Returns the air kerma of the photons in a spectrum, in uGy.
double air_kerma_uGy(const Spectrum &photons_mm2);

// Returns the fraction of photons of the given energy that the scintillator absorbs. The scintillator is
// simulated as 0.55 mm of CsI at the density of the crystal, which corresponds to a layer of needles about
// 0.6 mm thick.
double scintillator_absorption(int energy_index);

} // namespace crn
