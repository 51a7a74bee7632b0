// Computes differences of pictures: subtraction of a mask (DSA), the peak of opacification, and the roadmap.
// All functions use the logarithm of the raw values, because a vessel with contrast medium then looks equally
// dark in front of bone and of lung. Pixels are stored row by row, with row 0 on top. The functions use only
// sums, products and the polynomials of float_math, so that the results are bit-identical on every machine.
#pragma once
#include "host/xray/run.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace crn
{

// Computes log2 of the primary radiation in the raw values, smoothed by the display's filter [1 2 1]/4 in
// both directions; the value 0 counts as 1/2. `frame` states how the picture was taken. The estimated scatter
// is subtracted first, but never more than 0.9 of a value.
void primary_log2(const RunFrame &frame, std::span<const std::uint16_t> raw, int size,
                  std::vector<float> &log2_values);

// Returns the mean of the raw values of the frames that the mask names; frames that do not exist are left
// out. The returned mask is empty if none of the frames that the mask names exists.
std::vector<std::uint16_t> mean_frame(const XrayRun &run, const std::vector<int> &frames);

// Moves the picture `mask` to the right by dx and up by dy pixels with linear interpolation. Beyond the edge
// of the mask, the function uses the value at the edge.
void shift_picture(const std::vector<float> &mask, int size, double dx, double dy, std::vector<float> &moved);

// Computes mask - live: the density that was added after the mask was made, in doublings of attenuation. The
// density is 0 where the collimator covers one of the two pictures.
void subtract(const std::vector<float> &mask_log2, const std::vector<float> &live_log2,
              std::vector<float> &density);

// Converts density to grey: density 0 gives the grey value `background` (0 .. 255), a higher density is
// darker, and `window` doublings of attenuation are black.
void grey_of_density(const std::vector<float> &density, std::span<const std::uint8_t> open, float window,
                     std::uint8_t background, std::vector<std::uint8_t> &grey);

// Sets peak[i] to the larger of peak[i] and density[i] for every pixel i; if `peak` is empty, it becomes
// equal to `density`.
void hold_peak(const std::vector<float> &density, std::vector<float> &peak);

// Draws the peak of opacification (the densest state of each pixel) in white over a live picture. Before
// drawing, the function smooths the peak by the mean over 3 x 3 pixels and subtracts the noise, which is
// `floor` doublings of attenuation. Pixels within three pixels of black pixels are left out, because along
// the collimator blades the peak of opacification contains only noise.
void lay_roadmap(const std::vector<float> &peak, int size, float floor, std::vector<std::uint8_t> &grey);

} // namespace crn
