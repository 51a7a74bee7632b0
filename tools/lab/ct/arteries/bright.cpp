#include "tools/lab/ct/arteries/bright.hpp"
#include "tools/lab/ct/arteries/blocks.hpp"
#include "tools/lab/ct/arteries/tubes.hpp"
#include "tools/lab/ct/snake.hpp"
#include <algorithm>
#include <cmath>

namespace crn::ct
{

namespace
{

constexpr double small_share = 0.42; // of the way from tissue to arteries

// Large pieces that are brighter than the arteries. Their paths are wider the thicker a piece is, so that a
// streak of metal through the aorta claims nothing.
std::vector<Source> pieces_of(const Volume &scan, const Mask &body, float high_HU)
{
    constexpr double thickness = 2.0; // a compact shell of bone stands for the marrow behind it
    Mask mask(scan.count());
    for (std::size_t at = 0; at < mask.size(); ++at) mask[at] = body[at] && scan.hu[at] > high_HU;
    keep_pieces(scan, Pieces::large, piece_least_mm3, mask);
    const Widths widths = widths_in(scan, mask);
    std::vector<Source> found;
    for (std::size_t at = 0; at < mask.size(); ++at)
        if (mask[at])
            found.push_back(
                {at, static_cast<std::uint16_t>(std::min<double>(thickness * widths[at], width_most))});
    return found;
}

} // namespace

BrightRange bright_range(const Contrast &contrast)
{
    const double over_HU = contrast.mean_HU - surroundings_HU;
    return {static_cast<float>(surroundings_HU + std::max(small_share * over_HU, 2.5 * contrast.noise_HU)),
            static_cast<float>(contrast.mean_HU + std::max(4 * contrast.noise_HU, 0.25 * over_HU))};
}

Bright bright_of(const Volume &scan, const Mask &body, const Contrast &contrast)
{
    constexpr double even_mm = 1.0;
    const auto [low_HU, high_HU] = bright_range(contrast);
    const auto mean_HU = static_cast<float>(contrast.mean_HU), share = static_cast<float>(small_share);
    // A neighbourhood that is mostly air, fat or blood tells little.
    const BlockMeans tissue(scan, 6.0, 0.15, surroundings_HU, [&, low = low_HU](std::size_t at) {
        return body[at] && scan.hu[at] >= 0 && scan.hu[at] <= low;
    });
    Bright bright;
    // Keeps the voxels of the body that are bright in this volume.
    const auto keep = [&, low = low_HU](const Volume &volume, Mask &mask, const Mask &always) {
        for (int k = 0; k < scan.size[2]; ++k)
            for (int j = 0; j < scan.size[1]; ++j)
                for (int i = 0; i < scan.size[0]; ++i) {
                    const std::size_t at = scan.at(i, j, k);
                    if (!mask[at] || (!always.empty() && always[at])) continue;
                    const float around_HU = std::max(tissue.at(i, j, k), static_cast<float>(surroundings_HU));
                    mask[at] =
                        volume.hu[at] > low && volume.hu[at] > around_HU + share * (mean_HU - around_HU);
                }
    };
    bright.inside = body;
    keep(scan, bright.inside, {});
    bright.tubes = tubes_of(scan, bright.inside, contrast);
    Volume even = scan;
    for (float &hu : even.hu) hu = std::clamp(hu, 0.0f, high_HU);
    keep(smoothed(even, even_mm), bright.inside, grown(scan, bright.tubes, 1));
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
