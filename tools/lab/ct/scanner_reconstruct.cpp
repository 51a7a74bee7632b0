// Reconstructs by filtered back-projection of parallel rays, with a ramp filter with a Gaussian roll-off and
// linear interpolation.
#include "tools/lab/ct/scanner_parts.hpp"
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>

namespace crn::ct
{

namespace
{

constexpr double pi = 3.14159265358979323846;

int power_of_two(int least)
{
    int power = 1;
    while (power < least) power *= 2;
    return power;
}

} // namespace

Rays::Rays(int views_wanted, int bins_wanted, double pitch)
    : views(views_wanted), bins(bins_wanted), pitch_mm(pitch)
{
    for (int view = 0; view < views; ++view) {
        // The angles of the views avoid the axes; otherwise a whole edge of the phantom parallel to an axis
        // could fall between two rays.
        const double angle = pi * (view + 0.37) / views;
        cosine.push_back(std::cos(angle));
        sine.push_back(std::sin(angle));
    }
}

// The aperture (a box of one pitch) and the interpolation (a triangle) already blur the picture; the filter's
// roll-off adds the rest of the wanted blur.
Reconstruction::Reconstruction(const Rays &rays, double blur_mm) : rays_(rays)
{
    const double pitch = rays.pitch_mm;
    const double left = std::max(0.0, blur_mm * blur_mm - pitch * pitch * (1.0 / 12 + 1.0 / 6));
    const int size = power_of_two(2 * rays.bins);
    std::vector<std::complex<float>> space(static_cast<std::size_t>(size)), frequency;
    for (int i = 0; i < size; ++i) {
        const int n = i < size / 2 ? i : size - i;
        const double ramp = n == 0 ? 0.25 / pitch : n % 2 == 1 ? -1 / (pi * pi * n * n * pitch) : 0;
        space[static_cast<std::size_t>(i)] = static_cast<float>(ramp);
    }
    Eigen::FFT<float> fft;
    fft.fwd(frequency, space);
    for (int i = 0; i < size; ++i) {
        const double cycles_per_mm = (i < size / 2 ? i : size - i) / (size * pitch);
        response_.push_back(
            frequency[static_cast<std::size_t>(i)].real() *
            static_cast<float>(std::exp(-2 * pi * pi * left * cycles_per_mm * cycles_per_mm)));
    }
    // The filter's gain for white noise is the mean of |response|^2 over all frequencies. Linear
    // interpolation, averaged over all positions between samples, leaves 2/3 of this gain. After the ramp
    // filter, neighbouring noise values are hardly correlated; a test measures the resulting noise.
    for (const float value : response_) row_gain_ += static_cast<double>(value * value) / size;
    row_gain_ *= 2.0 / 3;
}

Reconstruction::~Reconstruction() = default;

// Filters two rows at once, as the real and imaginary part of one complex row, which is possible because the
// filter's response is real and even.
void Reconstruction::filter(std::vector<float> &lengths_mm) const
{
    const std::size_t bins = static_cast<std::size_t>(rays_.bins);
    std::vector<std::complex<float>> row(response_.size()), spectrum(response_.size());
    Eigen::FFT<float> fft;
    for (std::size_t view = 0; view < static_cast<std::size_t>(rays_.views); view += 2) {
        const bool has_pair = view + 1 < static_cast<std::size_t>(rays_.views);
        float *first = &lengths_mm[view * bins], *second = has_pair ? first + bins : nullptr;
        std::fill(row.begin(), row.end(), std::complex<float>{});
        for (std::size_t i = 0; i < bins; ++i) row[i] = {first[i], second ? second[i] : 0.0f};
        fft.fwd(spectrum, row);
        for (std::size_t i = 0; i < spectrum.size(); ++i) spectrum[i] *= response_[i];
        fft.inv(row, spectrum);
        for (std::size_t i = 0; i < bins; ++i) {
            first[i] = row[i].real();
            if (second) second[i] = row[i].imag();
        }
    }
}

void Reconstruction::project_back(const std::vector<float> &filtered, const Eigen::Vector2d &first,
                                  const Eigen::Vector2d &spacing, int columns, int rows, float *out_HU) const
{
    std::vector<float> sum(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0.0f);
    const double per_bin = 1 / rays_.pitch_mm;
    for (int view = 0; view < rays_.views; ++view) {
        const double c = rays_.cosine[static_cast<std::size_t>(view)],
                     s = rays_.sine[static_cast<std::size_t>(view)];
        const float *row = &filtered[static_cast<std::size_t>(view) * static_cast<std::size_t>(rays_.bins)];
        const auto step = static_cast<float>(spacing.x() * c * per_bin);
        for (int j = 0; j < rows; ++j) {
            const double y = first.y() + j * spacing.y();
            const auto begin = static_cast<float>((first.x() * c + y * s) * per_bin + 0.5 * rays_.bins - 0.5);
            float *out = &sum[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns)];
            for (int i = 0; i < columns; ++i) {
                const float place =
                    begin + step * static_cast<float>(i); // within the bins: the field of view is
                const int low = static_cast<int>(place);
                const float share = place - static_cast<float>(low);
                out[i] += row[low] + share * (row[low + 1] - row[low]);
            }
        }
    }
    const auto scale = static_cast<float>(1000 * pi / rays_.views);
    for (std::size_t i = 0; i < sum.size(); ++i) out_HU[i] = sum[i] * scale - 1000.0f;
}

double Reconstruction::noise_HU(const std::vector<float> &variance_mm2, const Eigen::Vector2d &place) const
{
    double sum = 0;
    for (int view = 0; view < rays_.views; ++view) {
        const double at = (place.x() * rays_.cosine[static_cast<std::size_t>(view)] +
                           place.y() * rays_.sine[static_cast<std::size_t>(view)]) /
                              rays_.pitch_mm +
                          0.5 * rays_.bins;
        sum += static_cast<double>(
            variance_mm2[static_cast<std::size_t>(view) * static_cast<std::size_t>(rays_.bins) +
                         static_cast<std::size_t>(std::clamp(static_cast<int>(at), 0, rays_.bins - 1))]);
    }
    return 1000 * pi / rays_.views * std::sqrt(sum * row_gain_);
}

} // namespace crn::ct
