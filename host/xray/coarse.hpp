// Quantities that change slowly over a picture (scatter and the display's slow part), on a grid of cells of
// 8x8 pixels.
#pragma once
#include <cstddef>
#include <vector>

namespace crn
{

inline constexpr int coarse_cell = 8; // pixels

// The open part of the field: columns [begin, end) of a row.
struct OpenColumns {
    int begin = 0, end = 0;
};

// Each cell has the sum over its open pixels and their number. Both vectors have (size/8)^2 values.
struct CoarseSums {
    std::vector<float> sum, count;

    explicit CoarseSums(int cells)
        : sum(static_cast<std::size_t>(cells) * cells, 0.0f), count(sum.size(), 0.0f)
    {
    }
    // Adds a row of a picture; one thread must add the rows of a cell, in order.
    void add_row(const float *values, int size, int row, const OpenColumns &open);
};
CoarseSums coarse_sums(const std::vector<float> &values, int size, const std::vector<OpenColumns> &open);

// Means over about a tenth of the picture: two passes of five cells along both axes. Closed pixels have no
// weight.
std::vector<float> slow_part(CoarseSums sums, int cells);

// Interpolates a grid bilinearly and returns one row at full size.
void slow_row(const std::vector<float> &grid, int size, int row, float *out);

} // namespace crn
