#include "host/records/identity.hpp"
#include "host/base/format.hpp"
#include "host/base/number_text.hpp"
#include "host/records/record.hpp"
#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sys/random.h>
#include <vector>

namespace crn
{

namespace
{

constexpr std::string_view space_of_records = "6f9c2d1e-3b47-4a80-9d4c-7e21b05fa386"; // a random number

// SHA-1 and SHA-256 (FIPS 180-4) both divide a message into blocks of 64 bytes, with the same padding
// (5.1.1).
template <std::size_t words> class Hash
{
  public:
    using Words = std::array<std::uint32_t, words>;
    using Block = std::array<std::uint32_t, 16>;
    Hash(const Words &begin, void (*take)(Words &hash, const Block &block)) : hash_(begin), take_(take) {}

    void add(std::string_view bytes)
    {
        length_ += bytes.size();
        for (char byte : bytes) {
            block_[used_ / 4] = block_[used_ / 4] << 8 | static_cast<std::uint8_t>(byte);
            if (++used_ < 64) continue;
            take_(hash_, block_);
            used_ = 0;
        }
    }

    std::array<std::uint8_t, 4 * words> finish()
    {
        const std::uint64_t bits = length_ * 8;
        add(std::string_view("\x80", 1));
        while (used_ != 56) add(std::string_view("\0", 1));
        for (int shift = 56; shift >= 0; shift -= 8) {
            const char byte = static_cast<char>(bits >> shift);
            add(std::string_view(&byte, 1));
        }
        std::array<std::uint8_t, 4 * words> digest;
        for (std::size_t i = 0; i < digest.size(); i++)
            digest[i] = static_cast<std::uint8_t>(hash_[i / 4] >> (24 - 8 * (i % 4)));
        return digest;
    }

  private:
    Words hash_;
    void (*take_)(Words &hash, const Block &block);
    Block block_{};
    std::size_t used_ = 0; // bytes of the block
    std::uint64_t length_ = 0;
};

// Holds the constants of SHA-256: the first 32 bits of the fractional parts of the cube roots of the first 64
// primes (FIPS 180-4, 4.2.2).
constexpr std::array<std::uint32_t, 64> sha_constants{
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

void take_block_256(std::array<std::uint32_t, 8> &hash, const std::array<std::uint32_t, 16> &block)
{
    std::array<std::uint32_t, 64> w;
    std::copy(block.begin(), block.end(), w.begin());
    for (std::size_t i = 16; i < 64; i++)
        w[i] = w[i - 16] + w[i - 7] + (std::rotr(w[i - 15], 7) ^ std::rotr(w[i - 15], 18) ^ w[i - 15] >> 3) +
               (std::rotr(w[i - 2], 17) ^ std::rotr(w[i - 2], 19) ^ w[i - 2] >> 10);
    auto [a, b, c, d, e, f, g, h] = hash;
    for (std::size_t i = 0; i < 64; i++) {
        const std::uint32_t first = h + (std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25)) +
                                    ((e & f) ^ (~e & g)) + sha_constants[i] + w[i];
        const std::uint32_t second =
            (std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22)) + ((a & b) ^ (a & c) ^ (b & c));
        h = g, g = f, f = e, e = d + first, d = c, c = b, b = a, a = first + second;
    }
    const std::array<std::uint32_t, 8> change{a, b, c, d, e, f, g, h};
    for (std::size_t i = 0; i < 8; i++) hash[i] += change[i];
}

void take_block_1(std::array<std::uint32_t, 5> &hash, const std::array<std::uint32_t, 16> &block)
{
    std::array<std::uint32_t, 80> w;
    std::copy(block.begin(), block.end(), w.begin());
    for (std::size_t i = 16; i < 80; i++) w[i] = std::rotl(w[i - 3] ^ w[i - 8] ^ w[i - 14] ^ w[i - 16], 1);
    auto [a, b, c, d, e] = hash;
    for (std::size_t i = 0; i < 80; i++) {
        const std::uint32_t mix = i < 20   ? ((b & c) ^ (~b & d)) + 0x5a827999
                                  : i < 40 ? (b ^ c ^ d) + 0x6ed9eba1
                                  : i < 60 ? ((b & c) ^ (b & d) ^ (c & d)) + 0x8f1bbcdc
                                           : (b ^ c ^ d) + 0xca62c1d6;
        const std::uint32_t next = std::rotl(a, 5) + mix + e + w[i];
        e = d, d = c, c = std::rotl(b, 30), b = a, a = next;
    }
    const std::array<std::uint32_t, 5> change{a, b, c, d, e};
    for (std::size_t i = 0; i < 5; i++) hash[i] += change[i];
}

// The initial hash of SHA-256 consists of the fractional parts of the square roots of the first eight primes
// (FIPS 180-4, 5.3.3).
Hash<8> sha256_hash()
{
    return {{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a, 0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19},
            take_block_256};
}

std::string hex_of(const std::array<std::uint8_t, 32> &digest)
{
    std::string text;
    for (std::uint8_t byte : digest) text += hex_text(byte, 2);
    return text;
}

std::string uuid_text(std::array<std::uint8_t, 16> bytes, int version)
{
    bytes[6] = static_cast<std::uint8_t>((bytes[6] & 0x0f) | version << 4);
    bytes[8] = static_cast<std::uint8_t>((bytes[8] & 0x3f) | 0x80);
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i++) {
        if (i == 4 || i == 6 || i == 8 || i == 10) text += '-';
        text += hex_text(bytes[i], 2);
    }
    return text;
}

std::int64_t unix_ms_now()
{
    using namespace std::chrono;
    return duration_cast<milliseconds>(system_clock::now().time_since_epoch()).count();
}

// Tests whether `text` has a digit in the place of every '0' of `form`, and otherwise the same characters.
bool has_form(std::string_view text, std::string_view form)
{
    if (text.size() != form.size()) return false;
    for (std::size_t i = 0; i < text.size(); i++)
        if (form[i] == '0' ? text[i] < '0' || text[i] > '9' : text[i] != form[i]) return false;
    return true;
}

int number_at(std::string_view text, std::size_t begin, std::size_t count)
{
    int number = 0;
    for (char digit : text.substr(begin, count)) number = number * 10 + (digit - '0');
    return number;
}

std::optional<std::chrono::sys_days> day_of(std::string_view text)
{
    using namespace std::chrono;
    const year_month_day day{year(number_at(text, 0, 4)), month(static_cast<unsigned>(number_at(text, 5, 2))),
                             std::chrono::day(static_cast<unsigned>(number_at(text, 8, 2)))};
    if (!day.ok()) return std::nullopt;
    return sys_days(day);
}

} // namespace

std::string new_uuid()
{
    std::array<std::uint8_t, 16> bytes;
    if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
        throw RecordsError(RecordsError::Cause::refused,
                           "the operating system gives no random numbers for the number of a session: " +
                               std::string(std::strerror(errno)));
    const std::int64_t now_ms = unix_ms_now();
    for (int i = 0; i < 6; i++)
        bytes[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(now_ms >> (40 - 8 * i));
    return uuid_text(bytes, 7);
}

std::string uuid_v5(std::string_view space, std::string_view name)
{
    Hash<5> hash({0x67452301, 0xefcdab89, 0x98badcfe, 0x10325476, 0xc3d2e1f0}, take_block_1);
    std::string digits;
    for (char digit : space)
        if (digit != '-') digits += digit;
    for (std::size_t i = 0; i + 1 < digits.size(); i += 2) {
        const char byte = static_cast<char>(std::stoi(digits.substr(i, 2), nullptr, 16));
        hash.add({&byte, 1});
    }
    hash.add(name);
    const auto digest = hash.finish();
    std::array<std::uint8_t, 16> bytes;
    std::copy_n(digest.begin(), bytes.size(), bytes.begin());
    return uuid_text(bytes, 5);
}

std::string uuid_of_name(std::string_view kind, std::string_view name)
{
    return uuid_v5(space_of_records, std::string(kind) + " " + std::string(name));
}

bool is_uuid(std::string_view text)
{
    if (text.size() != 36) return false;
    for (std::size_t i = 0; i < text.size(); i++) {
        const bool is_dash = i == 8 || i == 13 || i == 18 || i == 23;
        if (is_dash ? text[i] != '-' : std::string_view("0123456789abcdef").find(text[i]) == text.npos)
            return false;
    }
    return true;
}

std::string sha256(std::string_view bytes)
{
    Hash<8> hash = sha256_hash();
    hash.add(bytes);
    return hex_of(hash.finish());
}

std::optional<std::string> sha256_of_file(const std::string &path)
{
    std::ifstream file(path, std::ios::binary);
    std::vector<char> piece(1 << 16);
    Hash<8> hash = sha256_hash();
    while (file) {
        file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
        hash.add({piece.data(), static_cast<std::size_t>(file.gcount())});
    }
    if (!file.eof()) return std::nullopt;
    return hex_of(hash.finish());
}

std::string utc_text(std::int64_t unix_ms)
{
    using namespace std::chrono;
    const sys_time<milliseconds> moment{milliseconds(unix_ms)};
    const sys_days midnight = floor<days>(moment);
    const year_month_day day(midnight);
    const hh_mm_ss<milliseconds> clock(moment - midnight);
    return formatted("%04d-%02u-%02uT%02d:%02d:%02d.%03dZ", int{day.year()}, unsigned{day.month()},
                     unsigned{day.day()}, static_cast<int>(clock.hours().count()),
                     static_cast<int>(clock.minutes().count()), static_cast<int>(clock.seconds().count()),
                     static_cast<int>(clock.subseconds().count()));
}

std::string utc_now()
{
    return utc_text(unix_ms_now());
}

std::optional<std::int64_t> unix_ms_of(std::string_view text)
{
    if (!has_form(text, "0000-00-00T00:00:00.000Z")) return std::nullopt;
    const auto day = day_of(text);
    const int hour = number_at(text, 11, 2), minute = number_at(text, 14, 2), second = number_at(text, 17, 2);
    if (!day || hour > 23 || minute > 59 || second > 59) return std::nullopt;
    return std::int64_t{day->time_since_epoch().count()} * 86400000 +
           ((hour * 60 + minute) * 60 + second) * std::int64_t{1000} + number_at(text, 20, 3);
}

bool is_date(std::string_view text)
{
    return has_form(text, "0000-00-00") && day_of(text);
}

} // namespace crn
