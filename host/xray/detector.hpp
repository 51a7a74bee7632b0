// From path lengths to photons to grey values. Single-precision sums, products, quotients and square roots only, and
// integers: the same bytes from every compiler and thread count.
#pragma once
#include "host/xray/attenuation.hpp"
#include "host/xray/float_math.hpp"
#include "host/xray/xray.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace seld
{

// Share of the beam's photons that pass these path lengths (1/1024 mm per material).
float transmission(const std::array<float, material_count> &path_q10mm);

// One row of transmissions. paths[material] is the row's path lengths, or nullptr where the material is absent.
void transmission_row(const std::array<const std::int32_t *, material_count> &paths, int size, float *share);

// Photons counted when `expected` arrive on average: Poisson, a function of the key and the pixel only.
// Below 12 by inversion; above with the Poisson's mean, variance and skewness.
std::uint16_t count_photons(float expected, std::uint32_t key, std::uint32_t pixel);

// Key of one frame's noise.
std::uint32_t noise_key(std::uint64_t seed, std::uint32_t tick);

// Noise of a row of pixels that starts at `first_pixel`.
void count_row(const float *expected, int size, std::uint32_t key, std::uint32_t first_pixel,
               std::uint16_t *photons);

// The open part of the field: columns [begin, end) of a row.
struct OpenColumns {
    int begin = 0, end = 0;
};
OpenColumns open_columns(const XrayBeam &beam, int size, int row);

// Slow part of a picture on a grid of size/8: block means, then two 3x3 passes. Used for scatter and for the display.
std::vector<float> slow_part(const std::vector<float> &values, int size,
                             const std::vector<OpenColumns> &open);

// Row of the bilinear continuation of a slow part to full size.
void slow_row(const std::vector<float> &slow, int size, int row, float *out);

} // namespace seld
