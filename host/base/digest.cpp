#include "host/base/digest.hpp"
#include "host/base/format.hpp"
#include <algorithm>

namespace crn
{

namespace
{

using Wide = unsigned __int128;

constexpr Wide fnv_prime = (static_cast<Wide>(1) << 88) + 0x13b;

Wide bits(std::uint64_t high, std::uint64_t low)
{
    return (static_cast<Wide>(high) << 64) | low;
}

// The last bytes of the input hardly change the high bits of an FNV hash, so these bits are mixed once more.
Wide mixed(Wide value)
{
    for (int round = 0; round < 2; round++) {
        value ^= value >> 67;
        value *= bits(0x9e3779b97f4a7c15ULL, 0xf39cc0605cedc835ULL);
    }
    return value ^ (value >> 61);
}

} // namespace

void Digest::add(const void *bytes, std::size_t count)
{
    const auto *at = static_cast<const std::uint8_t *>(bytes);
    for (std::size_t i = 0; i < count; i++) value_ = (value_ ^ at[i]) * fnv_prime;
}

void Digest::add(std::string_view text)
{
    const std::uint64_t length = text.size();
    for (int shift = 0; shift < 64; shift += 8) {
        const auto byte = static_cast<std::uint8_t>(length >> shift);
        add(&byte, 1);
    }
    add(text.data(), text.size());
}

std::string Digest::hex() const
{
    const Wide value = mixed(value_);
    return formatted("%016llx%016llx", static_cast<unsigned long long>(value >> 64),
                     static_cast<unsigned long long>(value));
}

std::string Digest::uid() const
{
    // Sets version and variant of a UUID.
    Wide value = mixed(value_);
    value = (value & ~bits(0xf000, 0)) | bits(0x8000, 0);
    value = (value & ~bits(0, 0xc000000000000000ULL)) | bits(0, 0x8000000000000000ULL);
    std::string digits;
    for (; value != 0; value /= 10) digits += static_cast<char>('0' + static_cast<int>(value % 10));
    std::reverse(digits.begin(), digits.end());
    return "2.25." + digits;
}

} // namespace crn
