#include "host/room/subtraction.hpp"
#include "host/room/scatter_estimate.hpp"
#include "host/xray/coarse.hpp"
#include "host/xray/float_math.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

constexpr float roadmap_grey_per_doubling = 90.0f;
constexpr int roadmap_rim = 3; // pixels along the blades that are half dark and only noise

struct Neighbour {
    int low, high;
    float share; // of `high`
};

// Returns where the pixel at index `i` of a picture moved by `shift` was in the original picture.
Neighbour source_of(int i, double shift, int size)
{
    const double place = std::clamp(i - shift, 0.0, size - 1.0);
    const int low = std::min(static_cast<int>(place), size - 2);
    return {low, low + 1, static_cast<float>(place - low)};
}

// Returns true if a pixel is near the collimator blades, behind which the live picture is black.
bool is_near_blades(const std::vector<std::uint8_t> &grey, int size, int x, int y)
{
    const auto is_black = [&](int at_x, int at_y) {
        const std::size_t column = static_cast<std::size_t>(std::clamp(at_x, 0, size - 1));
        return grey[static_cast<std::size_t>(std::clamp(at_y, 0, size - 1)) * size + column] == 0;
    };
    return is_black(x - roadmap_rim, y) || is_black(x + roadmap_rim, y) || is_black(x, y - roadmap_rim) ||
           is_black(x, y + roadmap_rim);
}

} // namespace

void primary_log2(const RunFrame &frame, std::span<const std::uint16_t> raw, int size,
                  std::vector<float> &log2_values)
{
    constexpr float primary_least = 0.1f; // of the signal
    log2_values.resize(raw.size());
    const std::vector<float> scatter_cells = estimated_scatter(frame, raw, size);
    std::vector<float> scatter(static_cast<std::size_t>(size), 0.0f);
    std::vector<float> column(static_cast<std::size_t>(size));
    for (int y = 0; y < size; ++y) {
        const std::uint16_t *above = raw.data() + static_cast<std::size_t>(std::max(y - 1, 0)) * size;
        const std::uint16_t *here = raw.data() + static_cast<std::size_t>(y) * size;
        const std::uint16_t *below = raw.data() + static_cast<std::size_t>(std::min(y + 1, size - 1)) * size;
        if (!scatter_cells.empty()) slow_row(scatter_cells, size, y, scatter.data());
        for (int x = 0; x < size; ++x) column[x] = static_cast<float>(above[x] + 2 * here[x] + below[x]);
        float *out = log2_values.data() + static_cast<std::size_t>(y) * size;
        for (int x = 0; x < size; ++x) {
            const float sum =
                column[std::max(x - 1, 0)] + 2.0f * column[x] + column[std::min(x + 1, size - 1)];
            const float signal = sum * 0.0625f;
            const float primary = std::max(signal - scatter[x], primary_least * signal);
            out[x] = log2_positive(std::max(primary, 0.5f));
        }
    }
}

std::vector<std::uint16_t> mean_frame(const XrayRun &run, const std::vector<int> &frames)
{
    std::vector<std::uint32_t> sum;
    std::uint32_t count = 0;
    for (int frame : frames) {
        if (frame < 0 || static_cast<std::size_t>(frame) >= run.frames.size()) continue;
        const std::vector<std::uint16_t> &raw = run.frames[static_cast<std::size_t>(frame)].raw;
        if (sum.empty()) sum.assign(raw.size(), 0);
        if (raw.size() != sum.size()) continue;
        for (std::size_t i = 0; i < raw.size(); ++i) sum[i] += raw[i];
        ++count;
    }
    std::vector<std::uint16_t> mean(sum.size());
    for (std::size_t i = 0; i < sum.size(); ++i)
        mean[i] = static_cast<std::uint16_t>((sum[i] + count / 2) / count);
    return mean;
}

void shift_picture(const std::vector<float> &mask, int size, double dx, double dy, std::vector<float> &moved)
{
    moved.resize(mask.size());
    std::vector<Neighbour> columns;
    for (int x = 0; x < size; ++x) columns.push_back(source_of(x, dx, size));
    for (int y = 0; y < size; ++y) {
        const Neighbour row = source_of(y, -dy, size); // up is towards row 0
        const float *low = mask.data() + static_cast<std::size_t>(row.low) * size;
        const float *high = mask.data() + static_cast<std::size_t>(row.high) * size;
        float *out = moved.data() + static_cast<std::size_t>(y) * size;
        for (int x = 0; x < size; ++x) {
            const Neighbour &column = columns[static_cast<std::size_t>(x)];
            const float left = low[column.low] + row.share * (high[column.low] - low[column.low]);
            const float right = low[column.high] + row.share * (high[column.high] - low[column.high]);
            out[x] = left + column.share * (right - left);
        }
    }
}

void subtract(const std::vector<float> &mask_log2, const std::vector<float> &live_log2,
              std::vector<float> &density)
{
    constexpr float shut = -0.5f; // raw below 3/4: behind the blades
    density.resize(live_log2.size());
    for (std::size_t i = 0; i < live_log2.size(); ++i) {
        const bool is_open = mask_log2[i] > shut && live_log2[i] > shut;
        density[i] = is_open ? mask_log2[i] - live_log2[i] : 0.0f;
    }
}

void grey_of_density(const std::vector<float> &density, std::span<const std::uint8_t> open, float window,
                     std::uint8_t background, std::vector<std::uint8_t> &grey)
{
    grey.resize(density.size());
    const float gain = 255.0f / window;
    for (std::size_t i = 0; i < density.size(); ++i) {
        const float value = static_cast<float>(background) - gain * density[i];
        grey[i] = open[i] ? static_cast<std::uint8_t>(std::clamp(value + 0.5f, 0.0f, 255.0f)) : 0;
    }
}

void hold_peak(const std::vector<float> &density, std::vector<float> &peak)
{
    if (peak.size() != density.size()) {
        peak = density;
        return;
    }
    for (std::size_t i = 0; i < density.size(); ++i) peak[i] = std::max(peak[i], density[i]);
}

void lay_roadmap(const std::vector<float> &peak, int size, float floor, std::vector<std::uint8_t> &grey)
{
    if (peak.size() != grey.size()) return;
    const std::vector<std::uint8_t> live = grey;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            if (is_near_blades(live, size, x, y)) continue;
            float sum = 0.0f;
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx)
                    sum += peak[static_cast<std::size_t>(std::clamp(y + dy, 0, size - 1)) * size +
                                static_cast<std::size_t>(std::clamp(x + dx, 0, size - 1))];
            const float density = std::clamp(sum * (1.0f / 9.0f) - floor, 0.0f, 3.0f);
            std::uint8_t &pixel = grey[static_cast<std::size_t>(y) * size + static_cast<std::size_t>(x)];
            const float value = static_cast<float>(pixel) + roadmap_grey_per_doubling * density;
            pixel = static_cast<std::uint8_t>(std::min(value, 255.0f));
        }
}

} // namespace crn
