// Attenuation, counting and the helpers of the display.
#include "host/xray/detector.hpp"
#include <algorithm>
#include <bit>
#include <cmath>

namespace seld
{
namespace
{

constexpr int lanes = 16; // pixels worked on together; sizes are multiples of it
constexpr float small_mean = 12.0f;
constexpr int slow_cell = 8;

// 2^f on [0, 1): minimax-like polynomial (Taylor of degree 6 about 1/2), relative error 1.2e-7.
inline float exp2_fraction(float f)
{
    const float x = (f - 0.5f) * 0.69314718f;
    float sum =
        1.0f + x * (1.0f + x * (0.5f + x * (0.16666667f +
                                            x * (0.041666668f + x * (0.0083333338f + x * 0.0013888889f)))));
    return sum * 1.41421356f;
}

inline float exp2_minus(float x)
{
    x = x < 126.0f ? x : 126.0f;
    const float y = 126.0f - x; // 2^-x = 2^y 2^-126
    const auto whole = static_cast<std::int32_t>(y);
    const float fraction = y - static_cast<float>(whole);
    const float scale = std::bit_cast<float>((whole + 1) << 23);
    return exp2_fraction(fraction) * scale;
}

// log2 of the mantissa m in [1, 2) through atanh: s = (m - q)/(m + q), q = sqrt 2.
inline float log2_of(float x)
{
    const auto bits = std::bit_cast<std::int32_t>(x);
    const float exponent = static_cast<float>((bits >> 23) - 127);
    const float m = std::bit_cast<float>((bits & 0x7fffff) | 0x3f800000);
    const float s = (m - 1.41421356f) / (m + 1.41421356f), s2 = s * s;
    return exponent + 0.5f + s * (2.8853901f + s2 * (0.96179669f + s2 * (0.57707802f + s2 * 0.41219859f)));
}

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
    float term = exp2_minus(expected * 1.44269504f), sum = term;
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

float exp2_negative(float x)
{
    return x >= 126.0f ? 0.0f : exp2_minus(x);
}

float log2_positive(float x)
{
    return log2_of(x);
}

float transmission(const std::array<float, material_count> &path_q10mm)
{
    float share = 0.0f;
    for (int bin = 0; bin < beam_bin_count; ++bin) {
        float exponent = 0.0f;
        for (int m = 0; m < material_count; ++m)
            exponent = exponent + attenuation_log2_per_q10mm[m][bin] * path_q10mm[m];
        share = share + beam_share[bin] * exp2_minus(exponent > 0.0f ? exponent : 0.0f);
    }
    return share;
}

void transmission_row(const std::array<const std::int32_t *, material_count> &paths, int size, float *share)
{
    for (int x = 0; x < size; x += lanes) {
        float exponent[beam_bin_count][lanes] = {};
        for (int m = 0; m < material_count; ++m) {
            if (!paths[m]) continue;
            float path[lanes];
            for (int i = 0; i < lanes; ++i) path[i] = static_cast<float>(paths[m][x + i]);
            for (int bin = 0; bin < beam_bin_count; ++bin)
                for (int i = 0; i < lanes; ++i)
                    exponent[bin][i] += attenuation_log2_per_q10mm[m][bin] * path[i];
        }
        float sum[lanes] = {};
        for (int bin = 0; bin < beam_bin_count; ++bin)
            for (int i = 0; i < lanes; ++i) sum[i] += beam_share[bin] * exp2_minus(exponent[bin][i]);
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
    const int cells = size / slow_cell;
    auto locate = [&](int pixel, int &cell, float &share) {
        const int steps = std::clamp(2 * pixel + 1 - slow_cell, 0, 2 * slow_cell * (cells - 1));
        cell = std::min(steps / (2 * slow_cell), cells - 2);
        share = static_cast<float>(steps - cell * 2 * slow_cell) * (0.5f / slow_cell);
    };
    int cy;
    float sy;
    locate(row, cy, sy);
    const float *upper = slow.data() + static_cast<std::size_t>(cy) * cells, *lower = upper + cells;
    for (int x = 0; x < size; ++x) {
        int cx;
        float sx;
        locate(x, cx, sx);
        const float above = upper[cx] + sx * (upper[cx + 1] - upper[cx]);
        const float below = lower[cx] + sx * (lower[cx + 1] - lower[cx]);
        out[x] = above + sy * (below - above);
    }
}

} // namespace seld
