// Three things blur edges. Each has a modulation transfer function (MTF) over spatial frequency at the
// detector, 1/mm:
//
//   focal spot    |sinc(f a (m - 1))|, a its width, m = SID/SOD:
//                 a bright square seen through a point of the isocentre's plane
//   pixel         |sinc(f p)|, p the pixel's width
//   scintillator  1/(1 + H f^2), H = 0.5 mm2: Lorentzian fit of CsI, about .67/.33/.18
//                 at 1/2/3 per mm, as measured for panels after division by their pixel's share
//
// The expected signal is blurred by the focal spot and by the pixel before photons are drawn at random. After
// photons are drawn, the light in the scintillator spreads the contribution of each photon, so that the noise
// has the scintillator's texture. All blurs are symmetric kernels, applied along rows and then along columns.
// Up to 0.9 of half the sampling frequency, the modulation transfer function (MTF) of each kernel follows the
// formula in the list at the top of this file.
#pragma once
#include <array>
#include <cstdint>

namespace crn
{

inline constexpr int blur_radius_max = 12;

// tap[0] is the weight of the middle pixel, and tap[k] that of each of the two pixels at the distance k; all
// weights sum to 1.
struct BlurKernel {
    int radius = 0;
    std::array<float, blur_radius_max + 1> tap{1.0f};
    bool operator==(const BlurKernel &) const = default;
};

struct BlurGeometry {
    double pixel_mm = 0.6;      // at the detector
    double focal_spot_mm = 0.4; // width
    double magnification = 1.4; // of the blurred object: SID over its distance from the source
    bool operator==(const BlurGeometry &) const = default;
};

double mtf_of_focal_spot(const BlurGeometry &geometry, double frequency_per_mm);
double mtf_before_photons(const BlurGeometry &geometry, double frequency_per_mm); // focal spot and pixel
double mtf_of_scintillator(double frequency_per_mm);
double mtf_of_system(const BlurGeometry &geometry, double frequency_per_mm); // the product

// Each of the next functions returns a blur kernel. From frequency 0 to 0.9/(2 pixel), the kernel's MTF is
// within 0.01 of the formula at the top of this file, or as near to it as blur_radius_max allows.
BlurKernel kernel_before_photons(const BlurGeometry &geometry);
BlurKernel
kernel_of_focal_spot(const BlurGeometry &geometry); // for signals that are already averaged over each pixel
BlurKernel kernel_of_scintillator(double pixel_mm);

// Holds the three blur kernels of one geometry. Fitting the kernels takes longer than blurring a small
// picture, so the kernels are kept from picture to picture.
struct BlurKernels {
    BlurGeometry geometry;
    BlurKernel before_photons, focal_spot, scintillator;
};
BlurKernels kernels_of(const BlurGeometry &geometry);

// Computes one row of a blurred picture of size*size pixels. A pixel beyond an edge of the picture counts
// with the value of the nearest pixel on that edge. The caller provides the working memory `scratch` with
// size + 2 blur_radius_max values. `size` must be a multiple of 16.
void blur_row(const float *picture, int size, int row, const BlurKernel &kernel, float *scratch, float *out);
void blur_row(const std::uint32_t *picture, int size, int row, const BlurKernel &kernel, float *scratch,
              float *out);

} // namespace crn
