// Attenuation, counting and the helpers of the display.
#include "host/xray/detector.hpp"
#include <algorithm>
#include <cmath>

namespace seld
{
namespace
{

constexpr int lanes = 16; // pixels worked on together; sizes are multiples of it
constexpr float small_mean = 12.0f;
constexpr int slow_cell = 8;

// A well mixed 32-bit hash (two rounds of multiply and xor-shift).
inline std::uint32_t mix32(std::uint32_t x)
{
    x ^= x >> 16;
    x *= 0x21f0aaadu;
    x ^= x >> 15;
    x *= 0x735a2d97u;
    x ^= x >> 15;
    return x;
}

// Mean 0, variance 1, bell-shaped within +-3.46: the sum of four 16-bit uniform numbers.
inline float bell(std::uint32_t key, std::uint32_t pixel)
{
    const std::uint32_t a = mix32(pixel * 0x9e3779b9u + key), b = mix32(a ^ 0x85ebca6bu);
    const auto sum = static_cast<std::int32_t>((a & 0xffffu) + (a >> 16) + (b & 0xffffu) + (b >> 16));
    return static_cast<float>(sum - 2 * 65535) * 2.6428970e-5f; // sqrt(12/4)/65536
}

// Poisson by inversion of one 32-bit uniform number.
std::uint16_t count_few(float expected, std::uint32_t key, std::uint32_t pixel)
{
    if (!(expected > 0.0f)) return 0;
    const float uniform = static_cast<float>(mix32(mix32(pixel + key) ^ key) >> 8) * 5.9604645e-8f;
    float term = exp2_negative(expected * 1.44269504f), sum = term;
    std::uint16_t count = 0;
    while (uniform >= sum && count < 60) {
        ++count;
        term = term * expected / static_cast<float>(count);
        sum = sum + term;
    }
    return count;
}

inline float count_many(float expected, float z)
{
    const float spread = expected + std::sqrt(expected) * z;
    const float skewed = spread + (z * z - 1.0f) * 0.16666667f;
    const float held = skewed > 0.0f ? skewed : 0.0f;
    return held < 65535.0f ? held : 65535.0f;
}

} // namespace

float transmission(const std::array<float, material_count> &path_q10mm)
{
    float share = 0.0f;
    for (int bin = 0; bin < beam_bin_count; ++bin) {
        float exponent = 0.0f;
        for (int m = 0; m < material_count; ++m)
            exponent = exponent + attenuation_log2_per_q10mm[m][bin] * path_q10mm[m];
        share = share + beam_share[bin] * exp2_negative(exponent > 0.0f ? exponent : 0.0f);
    }
    return share;
}

void transmission_row(const std::array<const std::int32_t *, material_count> &paths, int size, float *share)
{
    for (int x = 0; x < size; x += lanes) {
        float exponent[beam_bin_count][lanes] = {};
        for (int m = 0; m < material_count; ++m) {
            if (!paths[m]) continue;
            std::int32_t any = 0;
            for (int i = 0; i < lanes; ++i) any |= paths[m][x + i];
            if (any == 0) continue;
            float path[lanes];
            for (int i = 0; i < lanes; ++i) path[i] = static_cast<float>(paths[m][x + i]);
            for (int bin = 0; bin < beam_bin_count; ++bin)
                for (int i = 0; i < lanes; ++i)
                    exponent[bin][i] += attenuation_log2_per_q10mm[m][bin] * path[i];
        }
        float sum[lanes] = {};
        for (int bin = 0; bin < beam_bin_count; ++bin)
            for (int i = 0; i < lanes; ++i) sum[i] += beam_share[bin] * exp2_negative(exponent[bin][i]);
        std::copy_n(sum, lanes, share + x);
    }
}

std::uint32_t noise_key(std::uint64_t seed, std::uint32_t tick)
{
    const auto low = static_cast<std::uint32_t>(seed), high = static_cast<std::uint32_t>(seed >> 32);
    return mix32(mix32(mix32(low) ^ high) + tick * 0x9e3779b9u);
}

std::uint16_t count_photons(float expected, std::uint32_t key, std::uint32_t pixel)
{
    if (!(expected >= small_mean)) return count_few(expected, key, pixel);
    return static_cast<std::uint16_t>(count_many(expected, bell(key, pixel)) + 0.5f);
}

void count_row(const float *expected, int size, std::uint32_t key, std::uint32_t first_pixel,
               std::uint16_t *photons)
{
    for (int x = 0; x < size; x += lanes) {
        float counts[lanes];
        float lowest = expected[x];
        for (int i = 0; i < lanes; ++i) {
            const float z = bell(key, first_pixel + static_cast<std::uint32_t>(x + i));
            counts[i] = count_many(expected[x + i], z) + 0.5f;
        }
        for (int i = 0; i < lanes; ++i) {
            photons[x + i] = static_cast<std::uint16_t>(static_cast<std::int32_t>(counts[i]));
            lowest = std::min(lowest, expected[x + i]);
        }
        if (lowest >= small_mean) continue;
        for (int i = 0; i < lanes; ++i)
            if (expected[x + i] < small_mean)
                photons[x + i] =
                    count_few(expected[x + i], key, first_pixel + static_cast<std::uint32_t>(x + i));
    }
}

OpenColumns open_columns(const XrayBeam &beam, int size, int row)
{
    const double half = 0.5 * size, open = half * beam.collimator_share;
    const double y = row + 0.5 - half;
    double reach = std::fabs(y) <= open ? open : -1.0;
    if (beam.circular_field) {
        const double square = open * open - y * y;
        reach = square > 0.0 ? std::sqrt(square) : -1.0;
    }
    if (reach < 0.0) return {};
    const int begin = static_cast<int>(std::floor(half - reach + 0.5));
    return {std::max(begin, 0), std::min(size - begin, size)};
}

std::vector<float> slow_part(const std::vector<float> &values, int size, const std::vector<OpenColumns> &open)
{
    const int cells = size / slow_cell;
    std::vector<float> mean(static_cast<std::size_t>(cells) * cells), weight(mean.size()), pass(mean.size());
    for (int cy = 0; cy < cells; ++cy)
        for (int cx = 0; cx < cells; ++cx) {
            float sum = 0.0f, count = 0.0f;
            for (int y = cy * slow_cell; y < (cy + 1) * slow_cell; ++y)
                for (int x = cx * slow_cell; x < (cx + 1) * slow_cell; ++x) {
                    if (x < open[y].begin || x >= open[y].end) continue;
                    sum += values[static_cast<std::size_t>(y) * size + x];
                    count += 1.0f;
                }
            mean[cy * cells + cx] = sum;
            weight[cy * cells + cx] = count;
        }
    // Weighted box blurs: what lies outside the collimator has no weight.
    auto blur = [&](std::vector<float> &grid, int dx, int dy) {
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
    };
    for (int repeat = 0; repeat < 2; ++repeat)
        for (std::vector<float> *grid : {&mean, &weight}) {
            blur(*grid, 1, 0);
            blur(*grid, 0, 1);
        }
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] = weight[i] > 0.0f ? mean[i] / weight[i] : 0.0f;
    return mean;
}

void slow_row(const std::vector<float> &slow, int size, int row, float *out)
{
    constexpr int half = slow_cell / 2;
    const int cells = size / slow_cell;
    const int steps = std::clamp(2 * row + 1 - slow_cell, 0, 2 * slow_cell * (cells - 1));
    const int cell = std::min(steps / (2 * slow_cell), cells - 2);
    const float share = static_cast<float>(steps - cell * 2 * slow_cell) * (0.5f / slow_cell);
    const float *upper = slow.data() + static_cast<std::size_t>(cell) * cells, *lower = upper + cells;
    float left = upper[0] + share * (lower[0] - upper[0]);
    std::fill(out, out + half, left);
    for (int c = 1; c < cells; ++c) {
        const float right = upper[c] + share * (lower[c] - upper[c]);
        const float step = (right - left) * (0.5f / slow_cell);
        float *begin = out + c * slow_cell - half;
        for (int k = 0; k < slow_cell; ++k) begin[k] = left + step * static_cast<float>(2 * k + 1);
        left = right;
    }
    std::fill(out + size - half, out + size, left);
}

} // namespace seld
