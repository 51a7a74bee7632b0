// From path lengths to transmitted shares, and from expected to counted quanta. Single-precision sums,
// products, quotients and square roots only, and integers: the same bytes from every compiler and thread
// count.
#pragma once
#include "host/xray/beam_table.hpp"
#include "host/xray/coarse.hpp"
#include "host/xray/float_math.hpp"
#include "host/xray/xray.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace crn
{

// Share of the open beam's signal that passes these path lengths (1/1024 mm per material).
float transmission(const BeamTable &beam, const std::array<float, material_count> &path_q10mm);

// One row of transmissions. paths[material] is the row's path lengths, or nullptr where the material is
// absent. Size is a multiple of 16.
void transmission_row(const BeamTable &beam, const std::array<const std::int32_t *, material_count> &paths,
                      int size, float *share);

// The most that a pixel counts.
inline constexpr std::uint32_t photons_max = 1u << 22;

// Photons counted when `expected` arrive on average: Poisson, a function of the key and the pixel only.
// Below 12 by inversion; above with the Poisson's mean, variance and skewness.
std::uint32_t count_photons(float expected, std::uint32_t key, std::uint32_t pixel);

// Key of one frame's noise.
std::uint32_t noise_key(std::uint64_t seed, std::uint32_t tick);

// Noise of a row of pixels that starts at `first_pixel`.
void count_row(const float *expected, int size, std::uint32_t key, std::uint32_t first_pixel,
               std::uint32_t *photons);

// The open part of a row of the field.
OpenColumns open_columns(const XrayBeam &beam, int size, int row);

} // namespace crn
