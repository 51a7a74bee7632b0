#include "tools/lab/ct/patient/bright.hpp"
#include <algorithm>
#include <cmath>

namespace crn::ct
{

namespace
{

constexpr double small_share = 0.42; // of the way from tissue to arteries
constexpr double piece_least_mm3 = 300;

// The mean of the soft tissue in the neighbourhood, on blocks of 6 mm.
class Tissue
{
  public:
    Tissue(const Volume &scan, const Mask &body, float low_HU) : scan_(scan)
    {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            voxels_[axis] =
                std::max(1, static_cast<int>(6.0 / scan.spacing_mm[static_cast<Eigen::Index>(axis)]));
            size_[axis] = (scan.size[axis] + voxels_[axis] - 1) / voxels_[axis];
        }
        std::vector<double> sums(count()), counts(count());
        for (int k = 0; k < scan.size[2]; ++k)
            for (int j = 0; j < scan.size[1]; ++j)
                for (int i = 0; i < scan.size[0]; ++i) {
                    const std::size_t at = scan.at(i, j, k);
                    if (!body[at] || scan.hu[at] < 0 || scan.hu[at] > low_HU) continue;
                    sums[block(i, j, k)] += static_cast<double>(scan.hu[at]);
                    counts[block(i, j, k)] += 1;
                }
        spread(sums);
        spread(counts);
        // A neighbourhood that is mostly air, fat or blood tells little.
        const double least = 0.15 * 27 * voxels_[0] * voxels_[1] * voxels_[2];
        mean_HU_.resize(count());
        for (std::size_t at = 0; at < sums.size(); ++at)
            mean_HU_[at] = static_cast<float>(
                counts[at] < least ? surroundings_HU : std::max(sums[at] / counts[at], surroundings_HU));
    }
    float at(int i, int j, int k) const { return mean_HU_[block(i, j, k)]; }

  private:
    std::size_t count() const
    {
        return static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]) *
               static_cast<std::size_t>(size_[2]);
    }
    std::size_t block(int i, int j, int k) const
    {
        return (static_cast<std::size_t>(k / voxels_[2]) * static_cast<std::size_t>(size_[1]) +
                static_cast<std::size_t>(j / voxels_[1])) *
                   static_cast<std::size_t>(size_[0]) +
               static_cast<std::size_t>(i / voxels_[0]);
    }
    // Adds the values of the 27 blocks around each.
    void spread(std::vector<double> &values) const
    {
        std::size_t step = 1;
        for (const int size : size_) {
            const std::vector<double> before = values;
            for (std::size_t at = 0; at < values.size(); ++at) {
                const int index = static_cast<int>(at / step % static_cast<std::size_t>(size));
                if (index > 0) values[at] += before[at - step];
                if (index + 1 < size) values[at] += before[at + step];
            }
            step *= static_cast<std::size_t>(size);
        }
    }

    const Volume &scan_;
    std::array<int, 3> voxels_, size_;
    std::vector<float> mean_HU_;
};

// Large pieces that are brighter than the arteries. Their paths are wider the thicker a piece is, so that a
// streak of metal through the aorta claims nothing.
std::vector<Source> pieces_of(const Volume &scan, const Mask &body, float high_HU)
{
    constexpr double thickness = 2.0; // a compact shell of bone stands for the marrow behind it
    enum : unsigned char { dark, bright, tried, large };
    Mask mask(scan.count());
    for (std::size_t at = 0; at < mask.size(); ++at)
        mask[at] = body[at] && scan.hu[at] > high_HU ? bright : dark;
    for (std::size_t at = 0; at < mask.size(); ++at) {
        if (mask[at] != bright) continue;
        const std::size_t count = flood(scan, mask, {at}, bright, tried);
        if (static_cast<double>(count) * scan.spacing_mm.prod() > piece_least_mm3)
            flood(scan, mask, {at}, tried, large);
    }
    for (unsigned char &value : mask) value = value == large;
    const Widths widths = widths_in(scan, mask);
    std::vector<Source> found;
    for (std::size_t at = 0; at < mask.size(); ++at)
        if (mask[at])
            found.push_back(
                {at, static_cast<std::uint16_t>(std::min<double>(thickness * widths[at], width_most))});
    return found;
}

} // namespace

Bright bright_of(const Volume &scan, const Mask &body, const Contrast &contrast)
{
    const double over_HU = contrast.mean_HU - surroundings_HU;
    const auto low_HU =
        static_cast<float>(surroundings_HU + std::max(small_share * over_HU, 2.5 * contrast.noise_HU));
    const auto high_HU =
        static_cast<float>(contrast.mean_HU + std::max(4 * contrast.noise_HU, 0.25 * over_HU));
    const auto mean_HU = static_cast<float>(contrast.mean_HU), share = static_cast<float>(small_share);
    const Tissue tissue(scan, body, low_HU);
    Bright bright;
    bright.inside.assign(scan.count(), 0);
    for (int k = 0; k < scan.size[2]; ++k)
        for (int j = 0; j < scan.size[1]; ++j)
            for (int i = 0; i < scan.size[0]; ++i) {
                const std::size_t at = scan.at(i, j, k);
                if (!body[at] || scan.hu[at] <= low_HU) continue;
                const float around_HU = tissue.at(i, j, k);
                bright.inside[at] = scan.hu[at] > around_HU + share * (mean_HU - around_HU);
            }
    bright.widths = widths_in(scan, bright.inside);
    bright.pieces = pieces_of(scan, body, high_HU);
    return bright;
}

void take_out(const Volume &scan, const std::vector<Ball> &balls, Bright &bright)
{
    if (balls.empty()) return;
    for (const Ball &ball : balls) for_ball(scan, ball, [&](std::size_t at) { bright.inside[at] = 0; });
    bright.widths = widths_in(scan, bright.inside);
}

} // namespace crn::ct
