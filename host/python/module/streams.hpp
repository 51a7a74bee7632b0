// Encodes pictures as PNG files (ISO/IEC 15948), whose pixels are a zlib stream (RFC 1950) of deflate blocks
// (RFC 1951).
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cournand_python
{

// Describes the pixels of a picture: `rows` rows of `columns` pixels of `bytes` bytes each. One byte is grey,
// two bytes are a grey number of 16 bits, and three bytes are red, green and blue.
struct Image {
    const std::uint8_t *pixels;
    std::size_t rows, columns, bytes;
};

// Writes a PNG file whose pixels are stored without compression, and returns its size in
// bytes. If `to` is nullptr, nothing is written.
std::size_t stored_png(const Image &picture, std::uint8_t *to);

// Returns a PNG file of a picture of one byte per pixel with large areas of equal pixels, such as masks.
std::vector<std::uint8_t> mask_png(const Image &picture);

// Updates the CRC-32 of ISO/IEC 15948, annex D, with more bytes; the CRC of no bytes is 0.
std::uint32_t crc32_of(std::uint32_t crc, const std::uint8_t *bytes, std::size_t count);

// Updates the checksum of RFC 1950 with more bytes; the checksum of no bytes is 1.
std::uint32_t adler32_of(std::uint32_t adler, const std::uint8_t *bytes, std::size_t count);

// Returns, for each bit of a byte from the lowest, the number of bytes in which this bit is set.
std::array<std::uint64_t, 8> count_bits(const std::uint8_t *bytes, std::size_t count);

} // namespace cournand_python
