// Approximates the Gaussian of the scatter on the coarse grid by three box blurs along each axis.
#include "host/xray/scatter.hpp"
#include "host/xray/float_math.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

constexpr double spread_mm = 60.0;

// Computes the mean over 2 reach + 1 cells; the cells outside the grid count as 0.
void box(const float *in, int count, int step, int reach, float *out, std::vector<float> &before)
{
    before.resize(count + 1);
    before[0] = 0.0f;
    for (int i = 0; i < count; ++i) before[i + 1] = before[i] + in[i * step];
    const float scale = 1.0f / static_cast<float>(2 * reach + 1);
    for (int i = 0; i < count; ++i)
        out[i * step] = (before[std::min(i + reach + 1, count)] - before[std::max(i - reach, 0)]) * scale;
}

} // namespace

void spread_scatter(std::vector<float> &grid, int cells, double cell_mm)
{
    std::vector<float> before;
    // Three box blurs of w cells, applied one after another, have the variance (w^2 - 1)/4 together.
    const double spread_cells = spread_mm / cell_mm;
    const int reach =
        std::max(static_cast<int>(0.5 * (std::sqrt(4.0 * spread_cells * spread_cells + 1.0) - 1.0) + 0.5), 1);
    for (int repeat = 0; repeat < 3; ++repeat) {
        for (int y = 0; y < cells; ++y) {
            float *row = grid.data() + static_cast<std::size_t>(y) * cells;
            box(row, cells, 1, reach, row, before);
        }
        for (int x = 0; x < cells; ++x) box(grid.data() + x, cells, cells, reach, grid.data() + x, before);
    }
}

std::vector<float> scatter_part(const CoarseSums &primary, int cells, double cell_mm)
{
    std::vector<float> grid(primary.sum.size());
    for (std::size_t i = 0; i < grid.size(); ++i) {
        if (!(primary.count[i] > 0.0f)) continue;
        const float mean = std::clamp(primary.sum[i] / primary.count[i], 1e-12f, 1.0f);
        const float open_share = primary.count[i] * (1.0f / (coarse_cell * coarse_cell));
        grid[i] = scatter_per_neper * open_share * mean * -log2_positive(mean) * 0.69314718f;
    }
    spread_scatter(grid, cells, cell_mm);
    return grid;
}

} // namespace crn
