// Blurs values that are zero except at some pixels, such as what tools take from the beam. The cost depends
// on the number of those pixels and not on the picture's size.
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
    // Blurs along rows, then along columns. `pixels` holds row*size + column, each once, with their values.
    // Beyond its edges the picture continues with its edge values. Sums have a fixed order, so the result has
    // the same bits everywhere.
    void run(int size, std::span<const std::int32_t> pixels, std::span<const float> values,
             const BlurKernel &kernel);

    // Result of the last run: the pixels that have become nonzero, and their values.
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
