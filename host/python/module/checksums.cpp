#include "host/python/module/streams.hpp"
#include <array>
#include <cstring>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace cournand_python
{

namespace
{

constexpr std::uint32_t polynomial = 0xedb88320u; // of the CRC; bit 31 is the coefficient of x^0

constexpr std::uint32_t times_x(std::uint32_t remainder)
{
    return (remainder >> 1) ^ ((remainder & 1u) != 0 ? polynomial : 0u);
}

constexpr std::array<std::uint32_t, 256> make_table()
{
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t i = 0; i < 256; i++) {
        std::uint32_t value = i;
        for (int bit = 0; bit < 8; bit++) value = times_x(value);
        table[i] = value;
    }
    return table;
}

constexpr std::array<std::uint32_t, 256> crc_table = make_table();

// `state` is the complement of the CRC.
std::uint32_t crc_by_table(std::uint32_t state, const std::uint8_t *bytes, std::size_t count)
{
    for (std::size_t i = 0; i < count; i++) state = crc_table[(state ^ bytes[i]) & 255u] ^ (state >> 8);
    return state;
}

#if defined(__x86_64__)

// Returns x^power modulo the polynomial, one place to the left: the product of two mirrored numbers lies one
// place too far to the right.
constexpr std::uint64_t power_of_x(int power)
{
    std::uint32_t remainder = 0x80000000u; // x^0
    for (int i = 0; i < power; i++) remainder = times_x(remainder);
    return static_cast<std::uint64_t>(remainder) << 1;
}

// Two factors that move 128 bits of a message `bits` bits ahead, one for each half.
struct Step {
    std::uint64_t first_half, second_half;
};

constexpr Step step_of(int bits)
{
    return {power_of_x(bits + 32), power_of_x(bits - 32)};
}

constexpr Step over_16_bytes = step_of(128), over_64_bytes = step_of(512);

__attribute__((target("pclmul,sse2"))) inline __m128i moved(__m128i part, __m128i factors)
{
    return _mm_xor_si128(_mm_clmulepi64_si128(part, factors, 0x00),
                         _mm_clmulepi64_si128(part, factors, 0x11));
}

__attribute__((target("pclmul,sse2"))) inline __m128i load(const std::uint8_t *bytes)
{
    return _mm_loadu_si128(reinterpret_cast<const __m128i *>(bytes));
}

__attribute__((target("pclmul,sse2"))) inline __m128i factors_of(const Step &step)
{
    return _mm_set_epi64x(static_cast<long long>(step.second_half), static_cast<long long>(step.first_half));
}

// Computes the state by products of polynomials, for a count that is a multiple of 64: 16 bytes are replaced
// by 16 bytes at a later place that have the same remainder (V. Gopal et al., "Fast CRC Computation for
// Generic Polynomials Using PCLMULQDQ Instruction", Intel, 2009).
__attribute__((target("pclmul,sse2"))) std::uint32_t
crc_by_products(std::uint32_t state, const std::uint8_t *bytes, std::size_t count)
{
    __m128i part[4];
    for (int k = 0; k < 4; k++) part[k] = load(bytes + 16 * k);
    part[0] = _mm_xor_si128(part[0], _mm_cvtsi32_si128(static_cast<int>(state)));
    const __m128i far = factors_of(over_64_bytes), near = factors_of(over_16_bytes);
    for (std::size_t at = 64; at < count; at += 64)
        for (int k = 0; k < 4; k++) part[k] = _mm_xor_si128(moved(part[k], far), load(bytes + at + 16 * k));
    __m128i sum = part[0];
    for (int k = 1; k < 4; k++) sum = _mm_xor_si128(moved(sum, near), part[k]);
    std::uint8_t last[16];
    std::memcpy(last, &sum, sizeof last);
    return crc_by_table(0, last, sizeof last);
}

#endif

constexpr std::size_t lanes = 32;
constexpr std::size_t most_at_once = 4096; // keeps all sums below 2^32
constexpr std::uint32_t adler_modulus = 65521;

#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__clang__)
#define CRN_STREAM_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define CRN_STREAM_WIDE
#endif

// Adds the bytes of a multiple of `lanes`: sums[0] + i counts the bytes, and sums[1] + i weights each byte by
// the number of later bytes in its lane.
CRN_STREAM_WIDE void add_lanes(const std::uint8_t *bytes, std::size_t count, std::uint32_t *plain,
                               std::uint32_t *weighted)
{
    std::uint32_t once[lanes] = {}, later[lanes] = {};
    for (std::size_t at = 0; at < count; at += lanes)
        for (std::size_t i = 0; i < lanes; i++) {
            later[i] += once[i];
            once[i] += bytes[at + i];
        }
    std::memcpy(plain, once, sizeof once);
    std::memcpy(weighted, later, sizeof later);
}

} // namespace

std::uint32_t crc32_of(std::uint32_t crc, const std::uint8_t *bytes, std::size_t count)
{
    std::uint32_t state = ~crc;
#if defined(__x86_64__)
    static const bool has_products = __builtin_cpu_supports("pclmul") != 0;
    const std::size_t whole = count / 64 * 64;
    if (has_products && whole > 0) {
        state = crc_by_products(state, bytes, whole);
        bytes += whole;
        count -= whole;
    }
#endif
    return ~crc_by_table(state, bytes, count);
}

std::uint32_t adler32_of(std::uint32_t adler, const std::uint8_t *bytes, std::size_t count)
{
    std::uint64_t first = adler & 0xffffu, second = adler >> 16;
    while (count >= lanes) {
        const std::size_t now = (count < most_at_once ? count : most_at_once) / lanes * lanes;
        std::uint32_t plain[lanes], weighted[lanes];
        add_lanes(bytes, now, plain, weighted);
        second += first * now;
        for (std::size_t i = 0; i < lanes; i++) {
            first += plain[i];
            second += static_cast<std::uint64_t>(weighted[i]) * lanes + plain[i] * (lanes - i);
        }
        first %= adler_modulus;
        second %= adler_modulus;
        bytes += now;
        count -= now;
    }
    for (std::size_t i = 0; i < count; i++) {
        first += bytes[i];
        second += first;
    }
    return static_cast<std::uint32_t>(second % adler_modulus << 16 | first % adler_modulus);
}

} // namespace cournand_python
