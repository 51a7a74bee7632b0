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

namespace
{

constexpr int block = 64; // columns: long enough for a loop of vectors, short enough for the nearest cache
constexpr std::int32_t nothing[block] = {};

// What some columns of a row have of the materials, and no others.
struct PresentPaths {
    const std::int32_t *path[material_count];
    float factor[material_count][beam_energy_count];
    float weight[beam_energy_count];
    int count = 0;

    void add(const std::int32_t *line, const std::array<float, beam_energy_count> &factors)
    {
        path[count] = line;
        std::copy(factors.begin(), factors.end(), factor[count++]);
    }
};

// All energies at once, so that each path is read once.
template <int count>
inline __attribute__((always_inline)) void pass_block(const PresentPaths &present, int columns, float *share)
{
    for (int i = 0; i < columns; ++i) {
        float path[count], sum = 0.0f;
        for (int j = 0; j < count; ++j) path[j] = static_cast<float>(present.path[j][i]);
        for (int k = 0; k < beam_energy_count; ++k) {
            float exponent = present.factor[0][k] * path[0];
            for (int j = 1; j < count; ++j) exponent += present.factor[j][k] * path[j];
            sum += present.weight[k] * exp2_negative(exponent);
        }
        share[i] = sum;
    }
}

} // namespace

// Loops of their own: among others, compilers do not turn them into vectors.

// Not 0 when any of them is.
SELD_WIDE static std::int32_t any_of(const std::int32_t *from, int count)
{
    std::int32_t any = 0;
    for (int i = 0; i < count; ++i) any |= from[i];
    return any;
}

SELD_WIDE static void pass_one(const PresentPaths &present, int columns, float *share)
{
    pass_block<1>(present, columns, share);
}

SELD_WIDE static void pass_two(const PresentPaths &present, int columns, float *share)
{
    pass_block<2>(present, columns, share);
}

SELD_WIDE static void pass_three(const PresentPaths &present, int columns, float *share)
{
    pass_block<3>(present, columns, share);
}

SELD_WIDE static void pass_four(const PresentPaths &present, int columns, float *share)
{
    pass_block<4>(present, columns, share);
}

SELD_WIDE static void pass_six(const PresentPaths &present, int columns, float *share)
{
    pass_block<6>(present, columns, share);
}

SELD_WIDE static void pass_nine(const PresentPaths &present, int columns, float *share)
{
    pass_block<9>(present, columns, share);
}

SELD_WIDE static void pass_all(const PresentPaths &present, int columns, float *share)
{
    pass_block<material_count>(present, columns, share);
}

void transmission_row(const BeamTable &beam, const std::array<const std::int32_t *, material_count> &paths,
                      int size, float *share)
{
    static constexpr struct {
        int count;
        void (*pass)(const PresentPaths &present, int columns, float *share);
    } passes[] = {{1, pass_one}, {2, pass_two},  {3, pass_three},           {4, pass_four},
                  {6, pass_six}, {9, pass_nine}, {material_count, pass_all}};
    for (int begin = 0; begin < size; begin += block) {
        const int columns = std::min(block, size - begin);
        PresentPaths present;
        std::copy(beam.share.begin(), beam.share.end(), present.weight);
        for (int m = 0; m < material_count; ++m)
            if (paths[m] && any_of(paths[m] + begin, columns) != 0)
                present.add(paths[m] + begin, beam.log2_per_q10mm[m]);
        const auto *fitting = passes;
        while (fitting->count < present.count) ++fitting;
        while (present.count < fitting->count) present.add(nothing, {});
        fitting->pass(present, columns, share + begin);
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
