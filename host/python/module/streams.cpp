#include "host/python/module/streams.hpp"
#include <algorithm>
#include <array>
#include <cstring>

namespace cournand_python
{

namespace
{

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint8_t signature[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
constexpr std::uint8_t zlib_head[] = {0x78, 0x01};
constexpr std::uint8_t no_filter = 0, filter_up = 2; // of a row
constexpr std::size_t block_most = 65535;            // bytes of a stored block
constexpr std::size_t block_head = 5;
constexpr std::size_t chunk_frame = 12; // length, kind and CRC

void put(std::uint8_t *&to, const void *from, std::size_t count)
{
    std::memcpy(to, from, count);
    to += count;
}

void put_u32(std::uint8_t *&to, std::uint32_t value) // the highest byte first
{
    for (int shift = 24; shift >= 0; shift -= 8) *to++ = static_cast<std::uint8_t>(value >> shift);
}

// Writes the length and the kind of a chunk, and returns where the CRC begins.
std::uint8_t *begin_chunk(std::uint8_t *&to, std::size_t bytes, const char *kind)
{
    put_u32(to, static_cast<std::uint32_t>(bytes));
    std::uint8_t *begin = to;
    put(to, kind, 4);
    return begin;
}

void end_chunk(std::uint8_t *&to, const std::uint8_t *begin)
{
    put_u32(to, crc32_of(0, begin, static_cast<std::size_t>(to - begin)));
}

void put_head(std::uint8_t *&to, const Image &picture)
{
    put(to, signature, sizeof signature);
    const std::uint8_t *begin = begin_chunk(to, 13, "IHDR");
    put_u32(to, static_cast<std::uint32_t>(picture.columns));
    put_u32(to, static_cast<std::uint32_t>(picture.rows));
    const std::uint8_t bits = picture.bytes == 2 ? 16 : 8, colour = picture.bytes == 3 ? 2 : 0;
    const std::uint8_t form[] = {bits, colour, 0, 0, 0};
    put(to, form, sizeof form);
    end_chunk(to, begin);
}

void put_end(std::uint8_t *&to)
{
    end_chunk(to, begin_chunk(to, 0, "IEND"));
}

constexpr std::size_t frame_bytes = sizeof signature + chunk_frame + 13 + chunk_frame; // without the pixels

// Writes bytes as stored blocks of block_most bytes, and computes their checksum.
class StoredBlocks
{
  public:
    StoredBlocks(std::uint8_t *&to, std::size_t count) : to_(to), left_(count)
    {
        put(to_, zlib_head, sizeof zlib_head);
    }

    void add(const std::uint8_t *bytes, std::size_t count)
    {
        adler_ = adler32_of(adler_, bytes, count);
        while (count > 0) {
            if (space_ == 0) begin_block();
            const std::size_t now = std::min(count, space_);
            put(to_, bytes, now);
            bytes += now;
            count -= now;
            space_ -= now;
        }
    }

    void end() { put_u32(to_, adler_); }

    static std::size_t bytes_for(std::size_t count)
    {
        return sizeof zlib_head + (count + block_most - 1) / block_most * block_head + count + 4;
    }

  private:
    void begin_block()
    {
        space_ = std::min(left_, block_most);
        left_ -= space_;
        const auto low = static_cast<std::uint8_t>(space_), high = static_cast<std::uint8_t>(space_ >> 8);
        const std::uint8_t head[block_head] = {static_cast<std::uint8_t>(left_ == 0), low, high,
                                               static_cast<std::uint8_t>(~low),
                                               static_cast<std::uint8_t>(~high)};
        put(to_, head, sizeof head);
    }

    std::uint8_t *&to_;
    std::size_t left_, space_ = 0; // bytes behind the current block, and bytes that this block still takes
    std::uint32_t adler_ = 1;
};

// Copies a row of pixels; numbers of 16 bits get their highest byte first.
void copy_row(const Image &picture, std::size_t row, std::uint8_t *to)
{
    const std::size_t bytes = picture.columns * picture.bytes;
    const std::uint8_t *from = picture.pixels + row * bytes;
    if (picture.bytes != 2) {
        std::memcpy(to, from, bytes);
        return;
    }
    for (std::size_t i = 0; i < picture.columns; i++) {
        std::uint16_t value;
        std::memcpy(&value, from + 2 * i, sizeof value);
        const auto turned = static_cast<std::uint16_t>(value << 8 | value >> 8);
        std::memcpy(to + 2 * i, &turned, sizeof turned);
    }
}

// --- run lengths as a deflate block with fixed codes (RFC 1951, 3.2.6) ---

// A code, whose first bit is the lowest one.
struct Code {
    std::uint32_t bits;
    unsigned count;
};

constexpr std::uint32_t mirrored(std::uint32_t bits, unsigned count)
{
    std::uint32_t turned = 0;
    for (unsigned i = 0; i < count; i++) turned |= (bits >> i & 1u) << (count - 1 - i);
    return turned;
}

constexpr Code code_of_symbol(unsigned symbol)
{
    if (symbol < 144) return {mirrored(0x30 + symbol, 8), 8};
    if (symbol < 256) return {mirrored(0x190 + symbol - 144, 9), 9};
    if (symbol < 280) return {mirrored(symbol - 256, 7), 7};
    return {mirrored(0xc0 + symbol - 280, 8), 8};
}

constexpr std::size_t run_least = 3, run_most = 258;
constexpr unsigned end_of_block = 256;

// Returns the code of a repetition of the last byte: the symbol of the length with its additional bits, and
// the five zeros of the distance 1.
constexpr Code code_of_run(std::size_t length)
{
    if (length == run_most) return {code_of_symbol(285).bits, code_of_symbol(285).count + 5};
    const auto beyond = static_cast<unsigned>(length - run_least);
    unsigned extra =
        0; // bits: lengths of 8 and more beyond the least have four symbols for each power of two
    while (beyond >> extra >= 8) extra++;
    const Code symbol = code_of_symbol(257 + 4 * extra + (beyond >> extra));
    return {symbol.bits | (beyond & ((1u << extra) - 1)) << symbol.count, symbol.count + extra + 5};
}

struct Codes {
    std::array<Code, 257> symbol{};
    std::array<Code, run_most + 1> run{};
};

constexpr Codes make_codes()
{
    Codes made;
    for (unsigned i = 0; i < made.symbol.size(); i++) made.symbol[i] = code_of_symbol(i);
    for (std::size_t i = run_least; i < made.run.size(); i++) made.run[i] = code_of_run(i);
    return made;
}

constexpr Codes codes = make_codes();

// Encodes bytes as literal bytes and repetitions of the last byte.
class RunBlock
{
  public:
    explicit RunBlock(Bytes &to) : to_(to) { put_code({3, 3}); } // the last block, with fixed codes

    void add(const std::uint8_t *bytes, std::size_t count)
    {
        for (std::size_t at = 0; at < count;) {
            const std::size_t run = run_at(bytes + at, count - at);
            at += run;
            repeat(bytes[at - 1], run);
        }
    }

    void end()
    {
        put_code(codes.symbol[end_of_block]);
        if (held_ > 0) put_code({0, 7}); // fills the last byte
    }

  private:
    // Returns the number of equal bytes at the beginning.
    static std::size_t run_at(const std::uint8_t *bytes, std::size_t count)
    {
        const std::uint64_t pattern = bytes[0] * 0x0101010101010101ull;
        std::size_t run = 1;
        for (std::uint64_t word; run + 8 <= count; run += 8) {
            std::memcpy(&word, bytes + run, sizeof word);
            if (word != pattern) break;
        }
        while (run < count && bytes[run] == bytes[0]) run++;
        return run;
    }

    void repeat(std::uint8_t value, std::size_t count)
    {
        if (!has_last_ || value != last_) {
            put_code(codes.symbol[value]);
            count--;
        }
        has_last_ = true;
        last_ = value;
        for (; count >= run_least; count -= std::min(count, run_most))
            put_code(codes.run[std::min(count, run_most)]);
        for (; count > 0; count--) put_code(codes.symbol[value]);
    }

    void put_code(const Code &code)
    {
        bits_ |= static_cast<std::uint64_t>(code.bits) << held_;
        for (held_ += code.count; held_ >= 8; held_ -= 8) {
            to_.push_back(static_cast<std::uint8_t>(bits_));
            bits_ >>= 8;
        }
    }

    Bytes &to_;
    std::uint64_t bits_ = 0;
    unsigned held_ = 0; // bits that wait for a whole byte
    bool has_last_ = false;
    std::uint8_t last_ = 0;
};

// Returns true if a row has the same pixels as the row above, and is not the first row.
bool is_repeated(const Image &picture, std::size_t row)
{
    const std::uint8_t *pixels = picture.pixels + row * picture.columns;
    return row > 0 && std::memcmp(pixels, pixels - picture.columns, picture.columns) == 0;
}

Bytes run_stream(const Image &picture)
{
    Bytes stream(zlib_head, zlib_head + sizeof zlib_head);
    stream.reserve(1 << 14);
    RunBlock block(stream);
    std::vector<std::uint8_t> line(picture.columns + 1);
    std::uint32_t adler = 1;
    for (std::size_t row = 0; row < picture.rows; row++) {
        const std::uint8_t *pixels = picture.pixels + row * picture.columns;
        // A row that repeats the row above has differences of zero; other rows have their pixels.
        const bool is_same = is_repeated(picture, row);
        const bool is_black = is_same && pixels[0] == 0 && pixels[picture.columns - 1] == 0 &&
                              std::memcmp(pixels, pixels + 1, picture.columns - 1) == 0;
        line[0] = is_same && !is_black ? filter_up : no_filter;
        if (line[0] == filter_up)
            std::memset(line.data() + 1, 0, picture.columns);
        else
            std::memcpy(line.data() + 1, pixels, picture.columns);
        block.add(line.data(), line.size());
        adler = adler32_of(adler, line.data(), line.size());
    }
    block.end();
    for (int shift = 24; shift >= 0; shift -= 8) stream.push_back(static_cast<std::uint8_t>(adler >> shift));
    return stream;
}

} // namespace

std::size_t stored_png(const Image &picture, std::uint8_t *to)
{
    const std::size_t row_bytes = picture.columns * picture.bytes + 1;
    const std::size_t stream = StoredBlocks::bytes_for(picture.rows * row_bytes);
    if (to == nullptr) return frame_bytes + chunk_frame + stream;
    const std::uint8_t *first = to;
    put_head(to, picture);
    const std::uint8_t *begin = begin_chunk(to, stream, "IDAT");
    std::vector<std::uint8_t> line(row_bytes, no_filter);
    StoredBlocks blocks(to, picture.rows * row_bytes);
    for (std::size_t row = 0; row < picture.rows; row++) {
        copy_row(picture, row, line.data() + 1);
        blocks.add(line.data(), row_bytes);
    }
    blocks.end();
    end_chunk(to, begin);
    put_end(to);
    return static_cast<std::size_t>(to - first);
}

std::vector<std::uint8_t> mask_png(const Image &picture)
{
    const Bytes stream = run_stream(picture);
    Bytes png(frame_bytes + chunk_frame + stream.size());
    std::uint8_t *to = png.data();
    put_head(to, picture);
    const std::uint8_t *begin = begin_chunk(to, stream.size(), "IDAT");
    put(to, stream.data(), stream.size());
    end_chunk(to, begin);
    put_end(to);
    return png;
}

std::array<std::uint64_t, 8> count_bits(const std::uint8_t *bytes, std::size_t count)
{
    constexpr std::uint64_t lowest = 0x0101010101010101ull; // of each byte
    std::array<std::uint64_t, 8> found{};
    for (std::size_t at = 0; at < count; at += 8) {
        std::uint64_t word = 0;
        std::memcpy(&word, bytes + at, std::min<std::size_t>(count - at, 8));
        if (word == 0) continue;
        for (unsigned bit = 0; bit < 8; bit++) found[bit] += ((word >> bit & lowest) * lowest) >> 56;
    }
    return found;
}

} // namespace cournand_python
