// Blur of values that are zero but at some pixels, such as what tools take from the beam: its cost goes with
// those pixels and not with the picture.
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
    // Blurs along rows, then along columns. `pixels`: row*size + column, each once, with their values. Beyond
    // its edges the picture goes on as at the edge. Sums have a fixed order, so the result is the same bits
    // everywhere.
    void run(int size, std::span<const std::int32_t> pixels, std::span<const float> values,
             const BlurKernel &kernel);

    // Of the last run: the pixels that are not zero any more, and their values.
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
    std::vector<std::uint8_t> is_reached_; // the same
    std::vector<std::int32_t> reached_;    // pixels of the pass under way
};

} // namespace crn
