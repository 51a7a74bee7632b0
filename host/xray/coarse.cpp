// Sums, blurs and interpolates values on the coarse grid.
#include "host/xray/coarse.hpp"
#include "host/xray/paths/lanes.hpp"
#include <algorithm>

namespace crn
{
namespace
{

// Computes the sum of five neighbouring cells along one axis; cells outside the grid do not contribute.
void blur_five(std::vector<float> &grid, int cells, int dx, int dy)
{
    std::vector<float> pass(grid.size());
    for (int cy = 0; cy < cells; ++cy)
        for (int cx = 0; cx < cells; ++cx) {
            float sum = 0.0f;
            for (int k = -2; k <= 2; ++k) {
                const int x = cx + k * dx, y = cy + k * dy;
                if (x >= 0 && x < cells && y >= 0 && y < cells) sum += grid[y * cells + x];
            }
            pass[cy * cells + cx] = sum;
        }
    grid.swap(pass);
}

} // namespace

// Adds to each cell the part of a row of pixels that lies in the cell, pixel by pixel in order.
CRN_WIDE static void add_cells(const float *values, int cells, float *sum)
{
    for (int c = 0; c < cells; ++c) {
        float part = 0.0f;
        for (int x = 0; x < coarse_cell; ++x) part += values[c * coarse_cell + x];
        sum[c] += part;
    }
}

void CoarseSums::add_row(const float *values, int size, int row, const OpenColumns &open)
{
    const int cells = size / coarse_cell;
    float *own_sum = sum.data() + static_cast<std::size_t>(row / coarse_cell) * cells;
    float *own_count = count.data() + static_cast<std::size_t>(row / coarse_cell) * cells;
    const int first_whole = std::min((open.begin + coarse_cell - 1) / coarse_cell, cells);
    const int behind_whole = std::max(open.end / coarse_cell, first_whole);
    add_cells(values + first_whole * coarse_cell, behind_whole - first_whole, own_sum + first_whole);
    for (int cx = first_whole; cx < behind_whole; ++cx) own_count[cx] += static_cast<float>(coarse_cell);
    auto add_partly_open = [&](int cx) {
        const int begin = std::max(cx * coarse_cell, open.begin);
        const int end = std::min((cx + 1) * coarse_cell, open.end);
        float part = 0.0f;
        for (int x = begin; x < end; ++x) part += values[x];
        own_sum[cx] += part;
        own_count[cx] += static_cast<float>(std::max(end - begin, 0));
    };
    for (int cx = 0; cx < first_whole; ++cx) add_partly_open(cx);
    for (int cx = behind_whole; cx < cells; ++cx) add_partly_open(cx);
}

CoarseSums coarse_sums(const std::vector<float> &values, int size, const std::vector<OpenColumns> &open)
{
    CoarseSums sums(size / coarse_cell);
    for (int row = 0; row < size; ++row)
        sums.add_row(values.data() + static_cast<std::size_t>(row) * size, size, row, open[row]);
    return sums;
}

std::vector<float> slow_part(CoarseSums sums, int cells)
{
    for (int repeat = 0; repeat < 2; ++repeat)
        for (std::vector<float> *grid : {&sums.sum, &sums.count}) {
            blur_five(*grid, cells, 1, 0);
            blur_five(*grid, cells, 0, 1);
        }
    for (std::size_t i = 0; i < sums.sum.size(); ++i)
        sums.sum[i] = sums.count[i] > 0.0f ? sums.sum[i] / sums.count[i] : 0.0f;
    return std::move(sums.sum);
}

CRN_WIDE void slow_row(const std::vector<float> &grid, int size, int row, float *out)
{
    constexpr int half = coarse_cell / 2;
    const int cells = size / coarse_cell;
    const int steps = std::clamp(2 * row + 1 - coarse_cell, 0, 2 * coarse_cell * (cells - 1));
    const int cell = std::min(steps / (2 * coarse_cell), cells - 2);
    const float share = static_cast<float>(steps - cell * 2 * coarse_cell) * (0.5f / coarse_cell);
    const float *upper = grid.data() + static_cast<std::size_t>(cell) * cells, *lower = upper + cells;
    float left = upper[0] + share * (lower[0] - upper[0]);
    std::fill(out, out + half, left);
    for (int c = 1; c < cells; ++c) {
        const float right = upper[c] + share * (lower[c] - upper[c]);
        const float step = (right - left) * (0.5f / coarse_cell);
        float *begin = out + c * coarse_cell - half;
        for (int k = 0; k < coarse_cell; ++k) begin[k] = left + step * static_cast<float>(2 * k + 1);
        left = right;
    }
    std::fill(out + size - half, out + size, left);
}

} // namespace crn
