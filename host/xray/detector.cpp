// Computes attenuation and counts photons.
#include "host/xray/detector.hpp"
#include "host/xray/paths/lanes.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

constexpr int lanes = 16; // pixels that are processed together; sizes are multiples of it
constexpr float small_mean = 12.0f;

// Computes a 32-bit hash that mixes all bits well, by two rounds of multiply and xor-shift.
inline std::uint32_t mix32(std::uint32_t x)
{
    x ^= x >> 16;
    x *= 0x21f0aaadu;
    x ^= x >> 15;
    x *= 0x735a2d97u;
    x ^= x >> 15;
    return x;
}

// Returns a random number of mean 0 and variance 1 within +-3.46, with a bell-shaped distribution: the sum of
// four uniform 16-bit numbers.
inline float bell(std::uint32_t key, std::uint32_t pixel)
{
    const std::uint32_t a = mix32(pixel * 0x9e3779b9u + key), b = mix32(a ^ 0x85ebca6bu);
    const auto sum = static_cast<std::int32_t>((a & 0xffffu) + (a >> 16) + (b & 0xffffu) + (b >> 16));
    return static_cast<float>(sum - 2 * 65535) * 2.6428970e-5f; // sqrt(12/4)/65536
}

// Draws a random number with Poisson's distribution by inversion of one uniform 32-bit number.
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

constexpr int block = 64; // columns whose materials are tested together

// Holds the path lengths along some columns of one row of pixels, only for those materials that occur there.
struct PresentPaths {
    const std::int32_t *path[material_count];
    const float *factor[material_count]; // of each energy
    int count = 0;
};

// Computes exp2_negative for eight values at the same time. The vector is passed by reference, because how a
// vector is passed by value depends on the processor.
inline __attribute__((always_inline)) void exp2_negative_lanes(Lanes_f &x)
{
    x = x < 126.0f ? x : 126.0f - Lanes_f{};
    const Lanes_f y = 126.0f - x;
    const Lanes_i whole = __builtin_convertvector(y, Lanes_i);
    const Lanes_f f = (y - __builtin_convertvector(whole, Lanes_f) - 0.5f) * 0.69314718f;
    const Lanes_i bits = (whole + 1) << 23;
    Lanes_f scale;
    __builtin_memcpy(&scale, &bits, sizeof scale);
    const Lanes_f sum =
        1.0f + f * (1.0f + f * (0.5f + f * (0.16666667f +
                                            f * (0.041666668f + f * (0.0083333338f + f * 0.0013888889f)))));
    x = sum * 1.41421356f * scale;
}

// Returns zero if all values are zero, and otherwise a number that is not zero.
CRN_WIDE std::int32_t any_of(const std::int32_t *from, int count)
{
    std::int32_t any = 0;
    for (int i = 0; i < count; ++i) any |= from[i];
    return any;
}

// Computes the transmission at all photon energies in one pass, so that each path length is read only once.
CRN_WIDE void pass_block(const PresentPaths &present, const float *weight, int columns, float *share)
{
    for (int i = 0; i < columns; i += lane_count) {
        Lanes_f exponent[beam_energy_count] = {};
        for (int j = 0; j < present.count; ++j) {
            const Lanes_i length = *reinterpret_cast<const Lanes_i_anywhere *>(present.path[j] + i);
            const Lanes_f path = __builtin_convertvector(length, Lanes_f);
            const float *factor = present.factor[j];
            for (int k = 0; k < beam_energy_count; ++k) exponent[k] += factor[k] * path;
        }
        Lanes_f sum{};
        for (int k = 0; k < beam_energy_count; ++k) {
            exp2_negative_lanes(exponent[k]);
            sum += weight[k] * exponent[k];
        }
        __builtin_memcpy(share + i, &sum, sizeof sum);
    }
}

} // namespace

void transmission_row(const BeamTable &beam, const std::array<const std::int32_t *, material_count> &paths,
                      int size, float *share)
{
    for (int begin = 0; begin < size; begin += block) {
        const int columns = std::min(block, size - begin);
        PresentPaths present;
        for (int m = 0; m < material_count; ++m) {
            if (!paths[m] || (paths[m][begin] == 0 && any_of(paths[m] + begin, columns) == 0)) continue;
            present.path[present.count] = paths[m] + begin;
            present.factor[present.count++] = beam.log2_per_q10mm[m].data();
        }
        pass_block(present, beam.share.data(), columns, share + begin);
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

CRN_WIDE void count_row(const float *expected, int size, std::uint32_t key, std::uint32_t first_pixel,
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

} // namespace crn
