// Converts path lengths to transmitted shares of the signal, and expected quanta to counted quanta. The
// functions use only integers and sums, products, quotients and square roots in single precision, so that the
// bytes are equal for every compiler and number of threads.
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

// Returns the share of the open beam's signal that is transmitted through these path lengths (1/1024 mm per
// material).
float transmission(const BeamTable &beam, const std::array<float, material_count> &path_q10mm);

// Computes one row of transmissions. paths[material] has the path lengths of the row; it is nullptr if the
// row has none of the material. `size` must be a multiple of 16.
void transmission_row(const BeamTable &beam, const std::array<const std::int32_t *, material_count> &paths,
                      int size, float *share);

// A pixel can count at most this number of quanta.
inline constexpr std::uint32_t photons_max = 1u << 22;

// Returns the number of photons counted when `expected` arrive on average. The number has Poisson's
// distribution and depends only on the key and the pixel. If `expected` is below 12, the function inverts
// Poisson's distribution. Otherwise the function uses a distribution with the same mean, variance and
// skewness as Poisson's.
std::uint32_t count_photons(float expected, std::uint32_t key, std::uint32_t pixel);

// Returns the key from which the noise of one frame is computed.
std::uint32_t noise_key(std::uint64_t seed, std::uint32_t tick);

// Counts the photons of a row of pixels that begins at pixel `first_pixel`.
void count_row(const float *expected, int size, std::uint32_t key, std::uint32_t first_pixel,
               std::uint32_t *photons);

// Returns the columns of a row that the collimator leaves open.
OpenColumns open_columns(const XrayBeam &beam, int size, int row);

} // namespace crn
