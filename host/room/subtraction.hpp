// Computes differences of pictures: DSA against a mask, peak opacification, the roadmap. All work on the
// logarithm of the raw values, because there a contrasted vessel is equally dark in front of bone and of
// lung. Pixels are row by row, row 0 on top. They use only sums, products and the polynomials of float_math.
#pragma once
#include "host/xray/run.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace crn
{

// log2 of raw values, smoothed by the display's [1 2 1]/4 in both directions; raw 0 counts as 1/2.
void smooth_log2(std::span<const std::uint16_t> raw, int size, std::vector<float> &log2_values);

// Returns the mean of the frames named by the mask, as raw values; frames that do not exist are left out. It
// is empty if there are none.
std::vector<std::uint16_t> mean_frame(const XrayRun &run, const std::vector<int> &frames);

// Moves `mask` to the right by dx and up by dy pixels with linear interpolation; beyond its edge the edge's
// value continues.
void shift_picture(const std::vector<float> &mask, int size, double dx, double dy, std::vector<float> &moved);

// Density added since the mask, in doublings of attenuation: mask - live; 0 outside the open field of either.
void subtract(const std::vector<float> &mask_log2, const std::vector<float> &live_log2,
              std::vector<float> &density);

// Converts density to grey: none is `background` (0 .. 255), more is darker, `window` doublings are black.
void grey_of_density(const std::vector<float> &density, std::span<const std::uint8_t> open, float window,
                     std::uint8_t background, std::vector<std::uint8_t> &grey);

// peak[i] = max(peak[i], density[i]); an empty peak becomes the density.
void hold_peak(const std::vector<float> &density, std::vector<float> &peak);

// Lays the peak over a live picture in white, after smoothing by the mean over 3 x 3 and removal of noise
// below `floor` doublings. Pixels within three pixels of black are left out, because along the blades there
// is only noise.
void lay_roadmap(const std::vector<float> &peak, int size, float floor, std::vector<std::uint8_t> &grey);

} // namespace crn
