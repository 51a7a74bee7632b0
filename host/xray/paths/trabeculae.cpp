// Makes the blocks of the trabecular texture with integers only, so that every compiler makes the same bytes.
#include "host/xray/paths/trabeculae.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace crn
{
namespace
{

constexpr int cell_count = 1 << 3 * grain_bits;
constexpr int stored_rms = 32; // of the finest block, so that 4 standard deviations fit into a byte

// The sizes of a cell: across the patient, and along it.
constexpr double cell_across_mm = 0.24, cell_along_mm = 0.6;

// The block is turned about the patient's long axis by an angle with the tangent 0.618, and its own long axis
// leans by 3 degrees. A flat face then meets the same cells again only after several periods.
constexpr double turn_cosine = 0.85065, turn_sine = 0.52573, lean = 0.055;

using Cells = std::vector<std::int32_t>; // [w][v][u]

constexpr std::array<int, 3> strides = {1, grain_cells, grain_cells *grain_cells};

// Replaces each value by the mean of itself and its neighbours along an axis, with the weights 1, 2, 1; this
// adds 1/2 to the variance of the blur. The block is periodic.
void blur(Cells &cells, int axis)
{
    const int stride = strides[static_cast<std::size_t>(axis)], period = stride * grain_cells;
    const Cells from = cells;
    for (int block = 0; block < cell_count; block += period)
        for (int i = 0; i < grain_cells; ++i) {
            const std::int32_t *at = from.data() + block + i * stride;
            const std::int32_t *before = from.data() + block + ((i + grain_cells - 1) % grain_cells) * stride;
            const std::int32_t *behind = from.data() + block + ((i + 1) % grain_cells) * stride;
            std::int32_t *to = cells.data() + block + i * stride;
            for (int k = 0; k < stride; ++k) to[k] = (before[k] + 2 * at[k] + behind[k] + 2) >> 2;
        }
}

void blur(Cells &cells, int times_across, int times_along)
{
    for (int i = 0; i < times_across; ++i) blur(cells, 0), blur(cells, 2);
    for (int i = 0; i < times_along; ++i) blur(cells, 1);
}

// White noise of 24 bits: the upper bits of a linear congruential generator (Knuth, MMIX).
Cells white_noise()
{
    Cells cells(cell_count);
    std::uint64_t state = 24;
    for (std::int32_t &cell : cells) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        cell = static_cast<std::int32_t>(state >> 40) - (1 << 23);
    }
    return cells;
}

// Noise with wavelengths of mostly 5 to 10 cells: the difference of two blurs of white noise.
Cells band_noise()
{
    constexpr int fine_times = 2, coarse_times = 8;
    Cells fine = white_noise();
    blur(fine, fine_times, fine_times);
    Cells coarse = fine;
    blur(coarse, coarse_times - fine_times, coarse_times - fine_times);
    for (std::size_t i = 0; i < fine.size(); ++i) fine[i] -= coarse[i];
    return fine;
}

std::int64_t root_mean_square(const Cells &cells)
{
    std::int64_t sum = 0;
    for (const std::int64_t cell : cells) sum += cell * cell / 64;
    const std::int64_t mean = sum / (cell_count / 64);
    std::int64_t root = 1;
    while (root * root < mean) root *= 2;
    for (std::int64_t bit = root / 2; bit > 0; bit /= 2)
        if ((root - bit) * (root - bit) >= mean) root -= bit;
    return root;
}

// A block is used for pixels, at the isocentre, of up to pixel_max_mm. The blur of white noise with a
// standard deviation of half a pixel needs 2 (0.5 pixel / cell)^2 passes.
struct Level {
    double pixel_max_mm;
    int passes_across, passes_along;
};
constexpr Level levels[] = {{0.2, 0, 0}, {0.283, 1, 0}, {0.4, 2, 0}, {0.566, 4, 1}, {1e9, 8, 1}};
constexpr std::size_t level_count = std::size(levels);

class Blocks
{
  public:
    Blocks()
    {
        Cells cells = band_noise();
        const std::int64_t rms = root_mean_square(cells);
        int across = 0, along = 0;
        for (std::size_t i = 0; i < level_count; ++i) {
            blur(cells, levels[i].passes_across - across, levels[i].passes_along - along);
            across = levels[i].passes_across, along = levels[i].passes_along;
            store(cells, rms, blocks_[i]);
        }
    }
    const std::int8_t *of(double pixel_mm) const
    {
        std::size_t i = 0;
        while (pixel_mm > levels[i].pixel_max_mm) ++i;
        return blocks_[i].data() + padding;
    }

  private:
    static constexpr int padding = 3;
    static void store(const Cells &cells, std::int64_t rms, std::vector<std::int8_t> &to)
    {
        to.assign(padding + cells.size(), 0);
        for (std::size_t i = 0; i < cells.size(); ++i) {
            const std::int64_t scaled = 2 * stored_rms * std::int64_t{cells[i]} + rms; // rounds to nearest
            const std::int64_t cell =
                scaled >= 0 ? scaled / (2 * rms) : -((2 * rms - 1 - scaled) / (2 * rms));
            to[padding + i] = static_cast<std::int8_t>(std::clamp<std::int64_t>(cell, -127, 127));
        }
    }
    std::array<std::vector<std::int8_t>, level_count> blocks_;
};

} // namespace

Eigen::Vector3f grain_place(const Eigen::Vector3i &point_um)
{
    const Eigen::Vector3d mm = point_um.cast<double>() * 1e-3;
    const double x = mm.x() + lean * mm.y();
    return Eigen::Vector3d((turn_cosine * x + turn_sine * mm.z()) / cell_across_mm, mm.y() / cell_along_mm,
                           (turn_cosine * mm.z() - turn_sine * x) / cell_across_mm)
        .cast<float>();
}

Grain grain_in(const View &view)
{
    static const Blocks blocks;
    constexpr double steep_um = 900.0; // no h where the depth changes more from pixel to pixel
    return {blocks.of(view.pixel_m * 1e3 * view.source_isocentre_m / view.source_detector_m),
            static_cast<float>(grain_rms_mm * 1024.0 / stored_rms),
            static_cast<float>(1.0 / (steep_um * steep_um))};
}

} // namespace crn
