// Blurs values that are zero except at some pixels, such as the signal that tools absorb. The cost depends on
// the number of those pixels, and not on the size of the picture.
#pragma once
#include "host/xray/blur.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace crn
{

class SparseBlur
{
  public:
    // Blurs first along rows and then along columns. `pixels` has the indices row*size + column, each only
    // once, and `values` their values. Beyond an edge of the picture its edge values continue. The sums have
    // a fixed order, so the result has the same bits everywhere.
    void run(int size, std::span<const std::int32_t> pixels, std::span<const float> values,
             const BlurKernel &kernel);

    // These return the result of the last run: the pixels that became nonzero, and their values.
    const std::vector<std::int32_t> &pixels() const { return pixels_; }
    const std::vector<float> &values() const { return values_; }

  private:
    struct Line { // pixels that lie `step` apart; their count is the picture's size
        int size, step;
        int place(std::int32_t pixel) const { return step == 1 ? pixel % size : pixel / size; }
    };
    void pass(const Line &line, const BlurKernel &kernel);

    std::vector<std::int32_t> pixels_;
    std::vector<float> values_;
    std::vector<float> picture_;           // size*size, zero between passes
    std::vector<std::uint8_t> is_reached_; // likewise
    std::vector<std::int32_t> reached_;    // pixels of the current pass
};

} // namespace crn
