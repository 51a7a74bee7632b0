// Figures of the beam and of every material, written by tools/check/make_attenuation.py.
#pragma once
#include "host/xray/materials.hpp"

namespace seld
{

inline constexpr int beam_bin_count = 5;

// Share of the photons detected without a patient that fall into each energy bin; they add up to 1.
extern const float beam_share[beam_bin_count];

// log2(1/transmission) of 1/1024 mm of material in each bin.
extern const float attenuation_log2_per_q10mm[material_count][beam_bin_count];

// Air kerma that comes with one detected photon per mm2: behind 20 cm of soft tissue, and in the open beam.
extern const double kerma_behind_patient_nGy_mm2;
extern const double kerma_open_nGy_mm2;

} // namespace seld
