// Converts path lengths to transmitted shares, and expected quanta to counted ones. It uses only integers and
// single-precision sums, products, quotients and square roots, so that every compiler and thread count gives
// the same bytes.
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

// Returns the share of the open beam's signal that passes these path lengths (1/1024 mm per material).
float transmission(const BeamTable &beam, const std::array<float, material_count> &path_q10mm);

// Computes one row of transmissions. paths[material] is the row's path lengths, or nullptr where the material
// is absent. Size is a multiple of 16.
void transmission_row(const BeamTable &beam, const std::array<const std::int32_t *, material_count> &paths,
                      int size, float *share);

// The largest count of a pixel.
inline constexpr std::uint32_t photons_max = 1u << 22;

// Returns the number of photons counted when `expected` arrive on average: Poisson, a function of the key and
// the pixel only. It uses inversion below 12; above, it uses a distribution with the Poisson's mean, variance
// and skewness.
std::uint32_t count_photons(float expected, std::uint32_t key, std::uint32_t pixel);

// Returns the key of one frame's noise.
std::uint32_t noise_key(std::uint64_t seed, std::uint32_t tick);

// Counts a row of pixels that starts at `first_pixel`.
void count_row(const float *expected, int size, std::uint32_t key, std::uint32_t first_pixel,
               std::uint32_t *photons);

// Returns the open part of a row of the field.
OpenColumns open_columns(const XrayBeam &beam, int size, int row);

} // namespace crn
