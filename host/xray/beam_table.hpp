// Describes an X-ray beam by a few photon energies. Each energy has its fraction of the detector's signal and
// the signal of one photon.
//
// Gauss's quadrature replaces the sum of exp(-mu L) over the spectrum by a sum over two energies below the K
// edge of iodine and four above it; mu is the attenuation and L the path length. The quadrature is exact for
// polynomials in 1/sqrt(energy): up to degree 3 below the K edge of iodine, and up to degree 7 above this
// edge. The weight function of the quadrature is the spectrum behind 10 cm of tissue and 1 mm of iohexol-350,
// so that the relative error is similar for thin and thick patients.
#pragma once
#include "host/xray/spectrum.hpp"
#include <array>
#include <span>

namespace crn
{

inline constexpr int beam_energy_count = 6;

struct BeamTable {
    std::array<double, beam_energy_count> energy_keV{};
    // Holds the fraction of the open beam's signal from each energy; the fractions add up to 1, except for
    // the quadrature's error (0.6 %). A photon's signal is the energy that the photon leaves in the
    // scintillator.
    std::array<float, beam_energy_count> share{};
    // Holds, for each material and energy, log2(1/transmission) of a layer of 1/1024 mm.
    std::array<std::array<float, beam_energy_count>, material_count> log2_per_q10mm{};

    // The signal of a beam is counted in quanta. A quantum is a photon with the energy (sum of E^2)/(sum of
    // E), where both sums run over the photons absorbed behind 20 cm of tissue. When the signal is counted in
    // quanta, the variance of the signal equals its mean.
    double quantum_keV = 0.0;
    double quanta_mm2_mAs = 0.0;          // of the open beam at 1 m, absorbed by the scintillator
    double air_kerma_uGy_mAs = 0.0;       // of the open beam at 1 m
    double patient_nGy_quantum_mm2 = 0.0; // air kerma behind 20 cm of tissue that brings one quantum per mm2
};

BeamTable make_beam_table(double tube_voltage_kV, double copper_mm);

// Makes a beam that consists of given single photon energies, at most beam_energy_count, with the given
// fractions of the detector's signal. A beam of single photon energies serves for comparisons with other
// programs.
BeamTable make_line_table(std::span<const double> energies_keV, std::span<const double> shares);

} // namespace crn
