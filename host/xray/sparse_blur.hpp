// Blurs values that are zero except at some pixels, such as the signal that tools absorb. The cost of the
// blur depends on the number of nonzero pixels, and not on the size of the picture.
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
    // Blurs the values first along rows and then along columns. `pixels` holds the indices row*size + column
    // of the pixels that are not zero, each index only once, and `values` holds their values. A pixel beyond
    // an edge of the picture counts with the value of the nearest pixel on that edge. The sums are made in a
    // fixed order, so the result is equal bit for bit on every machine.
    void run(int size, std::span<const std::int32_t> pixels, std::span<const float> values,
             const BlurKernel &kernel);

    // The next functions return the result of the last call of run(): the pixels that are not zero after the
    // blur, and their values.
    const std::vector<std::int32_t> &pixels() const { return pixels_; }
    const std::vector<float> &values() const { return values_; }

  private:
    struct Line { // pixels that lie `step` apart; their count is the picture's size
        int size, step;
    };
    // Finds the place of pixels on their lines, and keeps the last row.
    class Place
    {
      public:
        explicit Place(const Line &line) : line_(line) {}
        int of(std::int32_t pixel)
        {
            if (pixel < row_begin_ || pixel >= row_begin_ + line_.size) {
                row_ = pixel / line_.size;
                row_begin_ = row_ * line_.size;
            }
            return line_.step == 1 ? pixel - row_begin_ : row_;
        }

      private:
        Line line_;
        std::int32_t row_ = 0, row_begin_ = 0;
    };
    void pass(const Line &line, const BlurKernel &kernel);

    std::vector<std::int32_t> pixels_;
    std::vector<float> values_;
    std::vector<float> picture_;           // size*size, zero between passes
    std::vector<std::uint8_t> is_reached_; // likewise
    std::vector<std::int32_t> reached_;    // pixels of the current pass; longer than their count
};

} // namespace crn
