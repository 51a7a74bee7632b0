// Describes a beam as pictures use it: by a few energies, their shares of the detector's signal, and the
// signal of each photon.
//
// The sum of exp(-mu L) over the spectrum is replaced, by Gauss's quadrature, by a sum over two energies
// below the K edge of iodine and four above it. The quadrature is exact for polynomials of degree 3 and 7 in
// 1/sqrt(energy). The weight of the quadrature is the spectrum behind 10 cm of tissue and 1 mm of
// iohexol-350, so that the relative error is similar for all patients, from thin to thick.
#pragma once
#include "host/xray/spectrum.hpp"
#include <array>
#include <span>

namespace crn
{

inline constexpr int beam_energy_count = 6;

struct BeamTable {
    std::array<double, beam_energy_count> energy_keV{};
    // These are the shares of the energies in the open beam's signal; they add up to 1, except for the
    // quadrature's error (0.6 %). The signal of a photon is the energy that it leaves in the scintillator.
    std::array<float, beam_energy_count> share{};
    // For each material and energy, this is log2(1/transmission) of 1/1024 mm.
    std::array<std::array<float, beam_energy_count>, material_count> log2_per_q10mm{};

    // The signal is counted in quanta. A quantum is a photon with the energy (sum of E^2)/(sum of E), taken
    // over the photons absorbed behind 20 cm of tissue. In these units the variance of the signal equals its
    // mean.
    double quantum_keV = 0.0;
    double quanta_mm2_mAs = 0.0;          // of the open beam at 1 m, absorbed by the scintillator
    double air_kerma_uGy_mAs = 0.0;       // of the open beam at 1 m
    double patient_nGy_quantum_mm2 = 0.0; // air kerma behind 20 cm of tissue that brings one quantum per mm2
};

BeamTable make_beam_table(double tube_voltage_kV, double copper_mm);

// Makes a beam of given lines, at most beam_energy_count, with their shares of the signal. A beam of lines
// serves for comparisons with other programs.
BeamTable make_line_table(std::span<const double> energies_keV, std::span<const double> shares);

} // namespace crn
