// Computes quantities that change slowly over a picture (scatter, and the slow part of the display) on a grid
// whose cells have 8x8 pixels.
#pragma once
#include <cstddef>
#include <vector>

namespace crn
{

inline constexpr int coarse_cell = 8; // pixels

// Describes the part of a row that the collimator leaves open: columns [begin, end).
struct OpenColumns {
    int begin = 0, end = 0;
};

// Holds, for each cell of the coarse grid, the number of its open pixels (not covered by the collimator) and
// the sum over them. Both vectors have (size/8)^2 values.
struct CoarseSums {
    std::vector<float> sum, count;

    explicit CoarseSums(int cells)
        : sum(static_cast<std::size_t>(cells) * cells, 0.0f), count(sum.size(), 0.0f)
    {
    }
    // Adds one row of a picture to the sums of the coarse grid's cells. All rows of a cell must be added by
    // the same thread, in order.
    void add_row(const float *values, int size, int row, const OpenColumns &open);
};
CoarseSums coarse_sums(const std::vector<float> &values, int size, const std::vector<OpenColumns> &open);

// Returns for each cell the mean over a neighbourhood of about a tenth of the picture, computed by two passes
// over five cells along both axes. Closed pixels have no weight.
std::vector<float> slow_part(CoarseSums sums, int cells);

// Interpolates the coarse grid bilinearly, and computes one row of pixels of the result at full size.
void slow_row(const std::vector<float> &grid, int size, int row, float *out);

} // namespace crn
