// Converts path lengths to transmitted fractions of the signal, and expected quanta to counted quanta. The
// functions use only integers and single-precision sums, products, quotients and square roots, so that
// results are equal bit for bit with every compiler and any number of threads.
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

// Returns the fraction of the open beam's signal that passes through the given path lengths, which are in
// 1/1024 mm for each material.
float transmission(const BeamTable &beam, const std::array<float, material_count> &path_q10mm);

// Computes one row of transmissions. paths[material] points to the row's path lengths in this material, or is
// nullptr if the material does not occur in the row. `size` must be a multiple of 16.
void transmission_row(const BeamTable &beam, const std::array<const std::int32_t *, material_count> &paths,
                      int size, float *share);

// Gives the largest number of quanta that a pixel can count.
inline constexpr std::uint32_t photons_max = 1u << 22;

// Returns a random number of counted photons for a pixel at which `expected` photons arrive on average. The
// number of counted photons has Poisson's distribution and depends only on `expected`, the key and the pixel.
// If `expected` is below 12, the function inverts Poisson's distribution. If `expected` is 12 or more, the
// function uses a distribution with the same mean, variance and skewness as Poisson's.
std::uint32_t count_photons(float expected, std::uint32_t key, std::uint32_t pixel);

// Returns the key from which the random numbers for the noise of one frame are computed.
std::uint32_t noise_key(std::uint64_t seed, std::uint32_t tick);

// Draws the counted photons of a row of pixels; `first_pixel` is the index of the row's first pixel.
void count_row(const float *expected, int size, std::uint32_t key, std::uint32_t first_pixel,
               std::uint32_t *photons);

// Returns the columns of a row that the collimator leaves open.
OpenColumns open_columns(const XrayBeam &beam, int size, int row);

} // namespace crn
