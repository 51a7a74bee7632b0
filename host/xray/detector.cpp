// Attenuation and counting.
#include "host/xray/detector.hpp"
#include "host/xray/lanes.hpp"
#include <algorithm>
#include <cmath>

namespace seld
{
namespace
{

constexpr int lanes = 16; // pixels worked on together; sizes are multiples of it
constexpr float small_mean = 12.0f;

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
std::uint32_t count_few(float expected, std::uint32_t key, std::uint32_t pixel)
{
    if (!(expected > 0.0f)) return 0;
    const float uniform = static_cast<float>(mix32(mix32(pixel + key) ^ key) >> 8) * 5.9604645e-8f;
    float term = exp2_negative(expected * 1.44269504f), sum = term;
    std::uint32_t count = 0;
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
    return held < static_cast<float>(photons_max) ? held : static_cast<float>(photons_max);
}

} // namespace

float transmission(const BeamTable &beam, const std::array<float, material_count> &path_q10mm)
{
    float share = 0.0f;
    for (int k = 0; k < beam_energy_count; ++k) {
        float exponent = 0.0f;
        for (int m = 0; m < material_count; ++m)
            exponent = exponent + beam.log2_per_q10mm[m][k] * path_q10mm[m];
        share = share + beam.share[k] * exp2_negative(exponent > 0.0f ? exponent : 0.0f);
    }
    return share;
}

// Loops of their own: among others, compilers do not turn them into vectors.

// Not 0 when any of them is.
SELD_WIDE static std::int32_t take(const std::int32_t *from, int count, float *to)
{
    std::int32_t any = 0;
    for (int i = 0; i < count; ++i) {
        to[i] = static_cast<float>(from[i]);
        any |= from[i];
    }
    return any;
}

SELD_WIDE static void add_scaled(const float *from, float factor, int count, float *to)
{
    for (int i = 0; i < count; ++i) to[i] += factor * from[i];
}

SELD_WIDE static void add_passed(const float *exponent, float weight, int count, float *sum)
{
    for (int i = 0; i < count; ++i) sum[i] += weight * exp2_negative(exponent[i]);
}

// Both at once for three, six and nine materials.
SELD_WIDE static void add_passed_three(const float *const *path, const float *factor, float weight, int count,
                                       float *sum)
{
    const float *p0 = path[0], *p1 = path[1], *p2 = path[2];
    const float f0 = factor[0], f1 = factor[1], f2 = factor[2];
    for (int i = 0; i < count; ++i) sum[i] += weight * exp2_negative(f0 * p0[i] + f1 * p1[i] + f2 * p2[i]);
}

SELD_WIDE static void add_passed_six(const float *const *path, const float *factor, float weight, int count,
                                     float *sum)
{
    const float *p0 = path[0], *p1 = path[1], *p2 = path[2], *p3 = path[3], *p4 = path[4], *p5 = path[5];
    const float f0 = factor[0], f1 = factor[1], f2 = factor[2], f3 = factor[3], f4 = factor[4],
                f5 = factor[5];
    for (int i = 0; i < count; ++i)
        sum[i] += weight *
                  exp2_negative(f0 * p0[i] + f1 * p1[i] + f2 * p2[i] + f3 * p3[i] + f4 * p4[i] + f5 * p5[i]);
}

SELD_WIDE static void add_passed_nine(const float *const *path, const float *factor, float weight, int count,
                                      float *sum)
{
    const float *p0 = path[0], *p1 = path[1], *p2 = path[2], *p3 = path[3], *p4 = path[4], *p5 = path[5],
                *p6 = path[6], *p7 = path[7], *p8 = path[8];
    const float f0 = factor[0], f1 = factor[1], f2 = factor[2], f3 = factor[3], f4 = factor[4],
                f5 = factor[5], f6 = factor[6], f7 = factor[7], f8 = factor[8];
    for (int i = 0; i < count; ++i)
        sum[i] += weight * exp2_negative(f0 * p0[i] + f1 * p1[i] + f2 * p2[i] + f3 * p3[i] + f4 * p4[i] +
                                         f5 * p5[i] + f6 * p6[i] + f7 * p7[i] + f8 * p8[i]);
}

namespace
{

constexpr int fused_max = 9;
constexpr int block = 64; // columns: long enough to be a loop of vectors, short enough for the nearest cache

// What some columns of a row have of the materials, and no others; filled up with nothing to nine.
struct PresentPaths {
    float path[material_count + fused_max][block];
    const float *pointer[fused_max];
    int material[material_count];
    int count = 0;

    PresentPaths(const std::array<const std::int32_t *, material_count> &paths, int begin, int columns)
    {
        for (int m = 0; m < material_count; ++m) {
            if (!paths[m]) continue;
            if (take(paths[m] + begin, columns, path[count]) != 0) material[count++] = m;
        }
        for (int j = count; j < fused_max; ++j) std::fill_n(path[j], columns, 0.0f);
        for (int j = 0; j < fused_max; ++j) pointer[j] = path[j];
    }
    float factor(const BeamTable &beam, int j, int energy) const
    {
        return j < count ? beam.log2_per_q10mm[material[j]][energy] : 0.0f;
    }
};

} // namespace

void transmission_row(const BeamTable &beam, const std::array<const std::int32_t *, material_count> &paths,
                      int size, float *share)
{
    for (int begin = 0; begin < size; begin += block) {
        const int columns = std::min(block, size - begin);
        const PresentPaths present(paths, begin, columns);
        float *sum = share + begin;
        std::fill_n(sum, columns, 0.0f);
        for (int k = 0; k < beam_energy_count; ++k) {
            const float weight = beam.share[k];
            float factors[fused_max];
            for (int j = 0; j < fused_max; ++j) factors[j] = present.factor(beam, j, k);
            if (present.count <= fused_max) {
                auto add = present.count <= 3   ? add_passed_three
                           : present.count <= 6 ? add_passed_six
                                                : add_passed_nine;
                add(present.pointer, factors, weight, columns, sum);
                continue;
            }
            float exponent[block] = {};
            for (int j = 0; j < present.count; ++j)
                add_scaled(present.path[j], present.factor(beam, j, k), columns, exponent);
            add_passed(exponent, weight, columns, sum);
        }
    }
}

std::uint32_t noise_key(std::uint64_t seed, std::uint32_t tick)
{
    const auto low = static_cast<std::uint32_t>(seed), high = static_cast<std::uint32_t>(seed >> 32);
    return mix32(mix32(mix32(low) ^ high) + tick * 0x9e3779b9u);
}

std::uint32_t count_photons(float expected, std::uint32_t key, std::uint32_t pixel)
{
    if (!(expected >= small_mean)) return count_few(expected, key, pixel);
    return static_cast<std::uint32_t>(count_many(expected, bell(key, pixel)) + 0.5f);
}

SELD_WIDE void count_row(const float *expected, int size, std::uint32_t key, std::uint32_t first_pixel,
                         std::uint32_t *photons)
{
    for (int x = 0; x < size; x += lanes) {
        float counts[lanes];
        float lowest = expected[x];
        for (int i = 0; i < lanes; ++i) {
            const float z = bell(key, first_pixel + static_cast<std::uint32_t>(x + i));
            counts[i] = count_many(expected[x + i], z) + 0.5f;
        }
        for (int i = 0; i < lanes; ++i) {
            photons[x + i] = static_cast<std::uint32_t>(static_cast<std::int32_t>(counts[i]));
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
    const double half = 0.5 * size, width = half * beam.open_width_share,
                 height = half * beam.open_height_share;
    const double y = row + 0.5 - half;
    double reach = std::fabs(y) <= height ? width : -1.0;
    if (beam.circular_field) {
        const double open = std::min(width, height);
        const double square = open * open - y * y;
        reach = square > 0.0 ? std::sqrt(square) : -1.0;
    }
    if (reach < 0.0) return {};
    const int begin = static_cast<int>(std::floor(half - reach + 0.5));
    return {std::max(begin, 0), std::min(size - begin, size)};
}

} // namespace seld
