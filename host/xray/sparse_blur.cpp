// Blurs the listed pixels: writes their values into a picture, and collects the blurred values from it.
#include "host/xray/sparse_blur.hpp"
#include <algorithm>

namespace crn
{

void SparseBlur::run(int size, std::span<const std::int32_t> pixels, std::span<const float> values,
                     const BlurKernel &kernel)
{
    pixels_.assign(pixels.begin(), pixels.end());
    values_.assign(values.begin(), values.end());
    if (kernel.radius == 0) return;
    const std::size_t count = static_cast<std::size_t>(size) * size;
    if (picture_.size() != count) {
        picture_.assign(count, 0.0f);
        is_reached_.assign(count, 0);
    }
    pass({size, 1}, kernel);
    pass({size, size}, kernel);
}

// Blurs along one direction. Most pixels follow each other in a row, so that a division is rare.
void SparseBlur::pass(const Line &line, const BlurKernel &kernel)
{
    const int radius = kernel.radius;
    Place place(line);
    const std::size_t most = pixels_.size() * static_cast<std::size_t>(2 * radius + 1) + 1;
    if (reached_.size() < most) reached_.resize(most);
    std::int32_t *next = reached_.data();
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
        const std::int32_t pixel = pixels_[i];
        picture_[pixel] = values_[i];
        const int at = place.of(pixel);
        const int first = std::max(-radius, -at), last = std::min(radius, line.size - 1 - at);
        for (int k = first; k <= last; ++k) { // without a branch, which the processor could not predict
            *next = pixel + k * line.step;
            next += 1 - is_reached_[*next];
            is_reached_[pixel + k * line.step] = 1;
        }
    }
    const std::span<const std::int32_t> reached(reached_.data(), next);
    values_.resize(reached.size());
    for (std::size_t i = 0; i < reached.size(); ++i) {
        const std::int32_t pixel = reached[i];
        const int at = place.of(pixel);
        const float *value = picture_.data() + pixel;
        float sum = kernel.tap[0] * *value;
        if (at >= radius && at + radius < line.size) {
            for (int k = 1; k <= radius; ++k)
                sum += kernel.tap[k] * (value[-k * line.step] + value[k * line.step]);
        } else {
            for (int k = 1; k <= radius; ++k)
                sum += kernel.tap[k] * (value[-std::min(k, at) * line.step] +
                                        value[std::min(k, line.size - 1 - at) * line.step]);
        }
        values_[i] = sum;
        is_reached_[pixel] = 0;
    }
    for (const std::int32_t pixel : pixels_) picture_[pixel] = 0.0f;
    pixels_.assign(reached.begin(), reached.end());
}

} // namespace crn
