// Fits kernels to the curves of modulation transfer functions (MTF), and applies them.
#include "host/xray/blur.hpp"
#include "host/xray/float_math.hpp"
#include "host/xray/paths/lanes.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

constexpr double scintillator_H_mm2 = 0.5;
constexpr int frequency_steps = 64;  // of the band to which the kernel is fitted
constexpr double fitted_band = 0.45; // cycles per pixel: 0.9 of half the sampling frequency, where the curve
                                     // of a short kernel must be flat
constexpr double kernel_error = 0.01;

// Returns sin(pi x)/(pi x) up to its first zero, and 0 beyond it.
double sinc(double x)
{
    x = std::fabs(x);
    if (x >= 1.0) return 0.0;
    return x < 1e-6 ? 1.0 : sin_pi(x) / (x * 3.14159265358979323846);
}

double cycles_of(int step)
{
    return (step + 0.5) * fitted_band / frequency_steps;
}

// cos(2 pi turns) - 1
double cosine_less_one(double turns)
{
    const double s = sin_pi(turns - std::floor(turns));
    return -2.0 * s * s;
}

double mtf_of_kernel(const BlurKernel &kernel, double cycles_per_pixel)
{
    double sum = 1.0;
    for (int k = 1; k <= kernel.radius; ++k)
        sum += 2.0 * static_cast<double>(kernel.tap[k]) * cosine_less_one(k * cycles_per_pixel);
    return sum;
}

using Square =
    std::array<std::array<double, blur_radius_max + 1>, blur_radius_max>; // with the right-hand side

// Solves a system of linear equations by Gaussian elimination; the matrix must be symmetric and positive.
void solve(Square &rows, int count)
{
    for (int i = 0; i < count; ++i)
        for (int j = i + 1; j < count; ++j) {
            const double factor = rows[j][i] / rows[i][i];
            for (int k = i; k <= count; ++k) rows[j][k] -= factor * rows[i][k];
        }
    for (int i = count - 1; i >= 0; --i) {
        for (int k = i + 1; k < count; ++k) rows[i][count] -= rows[i][k] * rows[k][count];
        rows[i][count] /= rows[i][i];
    }
}

// Fits a kernel with sum 1 to a curve by least squares over the frequencies, and increases the kernel's
// radius until the fit is close enough.
template <class Curve> BlurKernel fit_kernel(Curve curve)
{
    BlurKernel kernel;
    for (int radius = 0; radius <= blur_radius_max; ++radius) {
        Square rows{};
        for (int i = 0; i < frequency_steps; ++i)
            for (int k = 0; k < radius; ++k) {
                const double own = 2.0 * cosine_less_one((k + 1) * cycles_of(i));
                for (int j = 0; j < radius; ++j)
                    rows[k][j] += own * 2.0 * cosine_less_one((j + 1) * cycles_of(i));
                rows[k][radius] += own * (curve(cycles_of(i)) - 1.0);
            }
        solve(rows, radius);
        kernel.radius = radius;
        double middle = 1.0, worst = 0.0;
        for (int k = 0; k < radius; ++k) {
            kernel.tap[k + 1] = static_cast<float>(rows[k][radius]);
            middle -= 2.0 * rows[k][radius];
        }
        kernel.tap[0] = static_cast<float>(middle);
        for (int i = 0; i < frequency_steps; ++i)
            worst = std::max(worst, std::fabs(mtf_of_kernel(kernel, cycles_of(i)) - curve(cycles_of(i))));
        if (worst <= kernel_error) break;
    }
    return kernel;
}

template <class Value>
inline __attribute__((always_inline)) void blur_row_of(const Value *picture, int size, int row,
                                                       const BlurKernel &kernel, float *scratch, float *out)
{
    constexpr int margin = blur_radius_max;
    auto line = [&](int at) {
        return picture + static_cast<std::size_t>(std::clamp(at, 0, size - 1)) * size;
    };
    auto number = [](Value value) {
        if constexpr (std::is_same_v<Value, float>)
            return value;
        else
            return static_cast<float>(static_cast<std::int32_t>(value));
    };
    float *column = scratch + margin;
    const Value *middle = line(row);
    for (int x = 0; x < size; ++x) column[x] = kernel.tap[0] * number(middle[x]);
    for (int k = 1; k <= kernel.radius; ++k) {
        const Value *above = line(row - k), *below = line(row + k);
        const float tap = kernel.tap[k];
        for (int x = 0; x < size; ++x) column[x] += tap * (number(above[x]) + number(below[x]));
    }
    for (int k = 1; k <= kernel.radius; ++k) {
        column[-k] = column[0];
        column[size - 1 + k] = column[size - 1];
    }
    for (int x = 0; x < size; ++x) out[x] = kernel.tap[0] * column[x];
    for (int k = 1; k <= kernel.radius; ++k) {
        const float tap = kernel.tap[k];
        for (int x = 0; x < size; ++x) out[x] += tap * (column[x - k] + column[x + k]);
    }
}

} // namespace

double mtf_of_focal_spot(const BlurGeometry &geometry, double frequency_per_mm)
{
    return sinc(frequency_per_mm * geometry.focal_spot_mm * (geometry.magnification - 1.0));
}

double mtf_before_photons(const BlurGeometry &geometry, double frequency_per_mm)
{
    return sinc(frequency_per_mm * geometry.pixel_mm) * mtf_of_focal_spot(geometry, frequency_per_mm);
}

double mtf_of_scintillator(double frequency_per_mm)
{
    return 1.0 / (1.0 + scintillator_H_mm2 * frequency_per_mm * frequency_per_mm);
}

double mtf_of_system(const BlurGeometry &geometry, double frequency_per_mm)
{
    return mtf_before_photons(geometry, frequency_per_mm) * mtf_of_scintillator(frequency_per_mm);
}

BlurKernel kernel_before_photons(const BlurGeometry &geometry)
{
    return fit_kernel(
        [&](double cycles) { return mtf_before_photons(geometry, cycles / geometry.pixel_mm); });
}

BlurKernel kernel_of_focal_spot(const BlurGeometry &geometry)
{
    return fit_kernel([&](double cycles) { return mtf_of_focal_spot(geometry, cycles / geometry.pixel_mm); });
}

BlurKernel kernel_of_scintillator(double pixel_mm)
{
    return fit_kernel([&](double cycles) { return mtf_of_scintillator(cycles / pixel_mm); });
}

BlurKernels kernels_of(const BlurGeometry &geometry)
{
    return {geometry, kernel_before_photons(geometry), kernel_of_focal_spot(geometry),
            kernel_of_scintillator(geometry.pixel_mm)};
}

CRN_WIDE void blur_row(const float *picture, int size, int row, const BlurKernel &kernel, float *scratch,
                       float *out)
{
    blur_row_of(picture, size, row, kernel, scratch, out);
}

CRN_WIDE void blur_row(const std::uint32_t *picture, int size, int row, const BlurKernel &kernel,
                       float *scratch, float *out)
{
    blur_row_of(picture, size, row, kernel, scratch, out);
}

} // namespace crn
