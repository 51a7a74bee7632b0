// Computes differences of pictures: DSA against a mask, the peak of opacification, and the roadmap. All
// functions use the logarithm of the raw values, in which a vessel with medium is equally dark in front of
// bone and of lung. Pixels are stored row by row, with row 0 on top. The functions use only sums, products
// and the polynomials of float_math, so that results are equal everywhere.
#pragma once
#include "host/xray/run.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace crn
{

// Computes log2 of raw values, smoothed by the display's filter [1 2 1]/4 in both directions; the raw value 0
// counts as 1/2.
void smooth_log2(std::span<const std::uint16_t> raw, int size, std::vector<float> &log2_values);

// Returns the mean of the frames that the mask names, as raw values; frames that do not exist are left out.
// The result is empty if none of the frames exists.
std::vector<std::uint16_t> mean_frame(const XrayRun &run, const std::vector<int> &frames);

// Moves `mask` to the right by dx and up by dy pixels with linear interpolation. Beyond the edge of the mask
// the value at the edge continues.
void shift_picture(const std::vector<float> &mask, int size, double dx, double dy, std::vector<float> &moved);

// Computes the density that was added after the mask, in doublings of attenuation: mask - live. The density
// is 0 outside the open field of either picture.
void subtract(const std::vector<float> &mask_log2, const std::vector<float> &live_log2,
              std::vector<float> &density);

// Converts density to grey: no density gives `background` (0 .. 255), more density is darker, and `window`
// doublings are black.
void grey_of_density(const std::vector<float> &density, std::span<const std::uint8_t> open, float window,
                     std::uint8_t background, std::vector<std::uint8_t> &grey);

// Computes peak[i] = max(peak[i], density[i]); if `peak` is empty, it becomes the density.
void hold_peak(const std::vector<float> &density, std::vector<float> &peak);

// Draws the peak in white over a live picture. Before that, the peak is smoothed by the mean over 3 x 3
// pixels, and `floor` doublings of noise are removed. Pixels within three pixels of black ones are left out,
// because along the blades there is only noise.
void lay_roadmap(const std::vector<float> &peak, int size, float floor, std::vector<std::uint8_t> &grey);

} // namespace crn
