#include "host/picture/mp4_file.hpp"
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <unistd.h>

namespace crn
{
namespace
{

constexpr std::uint64_t u32_max = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t moved_bytes_max = std::size_t{1} << 18; // by one read and one write

// Numbers in an MP4 file are stored with the most significant byte first. The parameter type of each function
// limits the numbers that the function can write.
class Mp4Bytes
{
  public:
    void u8(std::uint8_t value) { bytes.push_back(value); }
    void u16(std::uint16_t value) { put(value, 2); }
    void u32(std::uint32_t value) { put(value, 4); }
    void u64(std::uint64_t value) { put(value, 8); }
    void zeros(std::size_t count) { bytes.insert(bytes.end(), count, 0); }
    void text(const char *word) { bytes.insert(bytes.end(), word, word + std::strlen(word)); }
    void all(const std::vector<std::uint8_t> &more) { bytes.insert(bytes.end(), more.begin(), more.end()); }
    void u32_at(std::size_t place, std::uint32_t value)
    {
        for (std::size_t i = 0; i < 4; ++i)
            bytes[place + i] = static_cast<std::uint8_t>(value >> (24 - 8 * i) & 0xff);
    }
    std::vector<std::uint8_t> bytes;

  private:
    void put(std::uint64_t value, int width)
    {
        for (int shift = 8 * (width - 1); shift >= 0; shift -= 8)
            bytes.push_back(static_cast<std::uint8_t>(value >> shift & 0xff));
    }
};

// Writes an MP4 box, which is a block of the file that begins with its length and its type; the box ends when
// this C++ object is destroyed. The boxes of the MP4 file's index are shorter than 4 GiB, because the largest
// table has 4 bytes for each of at most 2^28 pictures.
class Mp4Box
{
  public:
    Mp4Box(Mp4Bytes &bytes, const char *type) : bytes_(bytes), begin_(bytes.bytes.size())
    {
        bytes.u32(0);
        bytes.text(type);
    }
    // A "full box" of the MP4 format also has a version number and 24 bits of flags.
    Mp4Box(Mp4Bytes &bytes, const char *type, std::uint32_t flags) : Mp4Box(bytes, type) { bytes.u32(flags); }
    ~Mp4Box() { bytes_.u32_at(begin_, static_cast<std::uint32_t>(bytes_.bytes.size() - begin_)); }
    Mp4Box(const Mp4Box &) = delete;
    Mp4Box &operator=(const Mp4Box &) = delete;

  private:
    Mp4Bytes &bytes_;
    std::size_t begin_;
};

void put_file_type(Mp4Bytes &bytes)
{
    const Mp4Box box(bytes, "ftyp");
    bytes.text("isom");
    bytes.u32(0x200);
    bytes.text("isomiso2avc1mp41");
}

// Writes the unit matrix, which tells the player neither to turn nor to scale the pictures.
void put_matrix(Mp4Bytes &bytes)
{
    for (int i = 0; i < 9; ++i) bytes.u32(i == 8 ? 0x40000000 : i % 4 == 0 ? 0x00010000 : 0);
}

void put_movie_header(Mp4Bytes &bytes, std::uint32_t pictures_per_s, std::uint32_t pictures)
{
    const Mp4Box box(bytes, "mvhd", 0);
    bytes.zeros(8); // no time of creation or change
    bytes.u32(pictures_per_s);
    bytes.u32(pictures);
    bytes.u32(0x00010000); // played at its own speed
    bytes.u16(0x0100);     // at full volume
    bytes.zeros(10);
    put_matrix(bytes);
    bytes.zeros(24);
    bytes.u32(2); // the next track's number
}

void put_track_header(Mp4Bytes &bytes, const Mp4Track &track, std::uint32_t pictures)
{
    const Mp4Box box(bytes, "tkhd", 3); // enabled, and part of the presentation
    bytes.zeros(8);
    bytes.u32(1); // this track's number
    bytes.zeros(4);
    bytes.u32(pictures);
    bytes.zeros(16); // layer, group, volume of sound
    put_matrix(bytes);
    bytes.u32(static_cast<std::uint32_t>(track.width) << 16);
    bytes.u32(static_cast<std::uint32_t>(track.height) << 16);
}

void put_media_header(Mp4Bytes &bytes, std::uint32_t pictures_per_s, std::uint32_t pictures)
{
    {
        const Mp4Box box(bytes, "mdhd", 0);
        bytes.zeros(8);
        bytes.u32(pictures_per_s);
        bytes.u32(pictures);
        bytes.u16(0x55c4); // "und": no language
        bytes.u16(0);
    }
    const Mp4Box box(bytes, "hdlr", 0);
    bytes.zeros(4);
    bytes.text("vide");
    bytes.zeros(12);
    bytes.text("pictures");
    bytes.u8(0);
}

// Writes what a decoder of H.264 must know (ISO/IEC 14496-15): profile and level, lengths of 4 bytes, and the
// two parameter sets.
void put_decoder(Mp4Bytes &bytes, const Mp4Track &track)
{
    const Mp4Box box(bytes, "avcC");
    bytes.u8(1);
    for (std::size_t i = 1; i < 4; ++i) bytes.u8(track.sequence_parameters[i]);
    bytes.u8(0xfc | 3);
    bytes.u8(0xe0 | 1);
    bytes.u16(static_cast<std::uint16_t>(track.sequence_parameters.size()));
    bytes.all(track.sequence_parameters);
    bytes.u8(1);
    bytes.u16(static_cast<std::uint16_t>(track.picture_parameters.size()));
    bytes.all(track.picture_parameters);
    // From the profile High upwards, the file also states the format of the samples: 4:2:0, with 8 bits each
    // for brightness and colour.
    if (track.sequence_parameters[1] < 100) return;
    for (const int value : {0xfc | 1, 0xf8 | 0, 0xf8 | 0, 0}) bytes.u8(static_cast<std::uint8_t>(value));
}

void put_description(Mp4Bytes &bytes, const Mp4Track &track)
{
    const Mp4Box table(bytes, "stsd", 0);
    bytes.u32(1);
    const Mp4Box box(bytes, "avc1");
    bytes.zeros(6);
    bytes.u16(1); // its data is in this file
    bytes.zeros(16);
    bytes.u16(static_cast<std::uint16_t>(track.width));
    bytes.u16(static_cast<std::uint16_t>(track.height));
    bytes.u32(0x00480000); // 72 dpi, in both directions
    bytes.u32(0x00480000);
    bytes.zeros(4);
    bytes.u16(1);    // one picture per sample
    bytes.zeros(32); // no name of a program
    bytes.u16(0x18); // colour without transparency
    bytes.u16(0xffff);
    put_decoder(bytes, track);
    const Mp4Box colours(bytes, "colr");
    bytes.text("nclx");
    for (int i = 0; i < 3; ++i) bytes.u16(1); // BT.709: primaries, transfer, matrix
    bytes.u8(0);                              // 16 .. 235, not 0 .. 255
}

// In this MP4 file, a chunk (a contiguous block of samples) is one second of pictures. Returns the entries of
// the MP4 table "stsc" (sample to chunk). Each entry of the table "stsc" describes consecutive chunks of
// equal length by the number of the first chunk (from 1) and the number of pictures per chunk.
std::vector<std::pair<std::uint32_t, std::uint32_t>> chunk_runs(std::size_t pictures, std::size_t per_chunk)
{
    std::vector<std::pair<std::uint32_t, std::uint32_t>> runs;
    const std::size_t whole = pictures / per_chunk, rest = pictures % per_chunk;
    if (whole > 0) runs.emplace_back(1, static_cast<std::uint32_t>(per_chunk));
    if (rest > 0) runs.emplace_back(static_cast<std::uint32_t>(whole + 1), static_cast<std::uint32_t>(rest));
    return runs;
}

// Returns the position in the file at which each chunk begins; `begin` is the position of the first picture.
void put_chunk_places(Mp4Bytes &bytes, const std::vector<std::uint32_t> &picture_bytes, std::size_t per_chunk,
                      std::uint64_t begin, bool is_wide)
{
    const Mp4Box box(bytes, is_wide ? "co64" : "stco", 0);
    bytes.u32(static_cast<std::uint32_t>((picture_bytes.size() + per_chunk - 1) / per_chunk));
    std::uint64_t place = begin;
    for (std::size_t i = 0; i < picture_bytes.size(); ++i) {
        if (i % per_chunk == 0 && is_wide) bytes.u64(place);
        if (i % per_chunk == 0 && !is_wide) bytes.u32(static_cast<std::uint32_t>(place));
        place += picture_bytes[i];
    }
}

struct Mp4Tables {
    const std::vector<std::uint32_t> &picture_bytes, &keys;
    std::uint64_t begin; // of the first picture in the file
    bool is_wide;        // places of chunks have 64 bits
};

void put_sample_tables(Mp4Bytes &bytes, const Mp4Track &track, const Mp4Tables &tables)
{
    const Mp4Box all(bytes, "stbl");
    const auto pictures = static_cast<std::uint32_t>(tables.picture_bytes.size());
    const auto per_chunk = static_cast<std::size_t>(track.pictures_per_s);
    put_description(bytes, track);
    {
        const Mp4Box box(bytes, "stts", 0);
        bytes.u32(pictures > 0 ? 1 : 0);
        if (pictures > 0) bytes.u32(pictures);
        if (pictures > 0) bytes.u32(1); // each lasts one unit of the clock
    }
    {
        const Mp4Box box(bytes, "stss", 0);
        bytes.u32(static_cast<std::uint32_t>(tables.keys.size()));
        for (const std::uint32_t number : tables.keys) bytes.u32(number);
    }
    {
        const Mp4Box box(bytes, "stsc", 0);
        const auto runs = chunk_runs(pictures, per_chunk);
        bytes.u32(static_cast<std::uint32_t>(runs.size()));
        for (const auto &[first, count] : runs) {
            bytes.u32(first);
            bytes.u32(count);
            bytes.u32(1);
        }
    }
    {
        const Mp4Box box(bytes, "stsz", 0);
        bytes.u32(0); // they differ
        bytes.u32(pictures);
        for (const std::uint32_t count : tables.picture_bytes) bytes.u32(count);
    }
    put_chunk_places(bytes, tables.picture_bytes, per_chunk, tables.begin, tables.is_wide);
}

void put_media(Mp4Bytes &bytes, const Mp4Track &track, const Mp4Tables &tables)
{
    const Mp4Box media(bytes, "mdia");
    put_media_header(bytes, static_cast<std::uint32_t>(track.pictures_per_s),
                     static_cast<std::uint32_t>(tables.picture_bytes.size()));
    const Mp4Box information(bytes, "minf");
    {
        const Mp4Box box(bytes, "vmhd", 1);
        bytes.zeros(8);
    }
    {
        const Mp4Box box(bytes, "dinf");
        const Mp4Box references(bytes, "dref", 0);
        bytes.u32(1);
        const Mp4Box here(bytes, "url ", 1); // the flag says: in this file
    }
    put_sample_tables(bytes, track, tables);
}

Mp4Bytes make_head(const Mp4Track &track, const Mp4Tables &tables, std::uint64_t data_bytes)
{
    Mp4Bytes bytes;
    put_file_type(bytes);
    {
        const Mp4Box movie(bytes, "moov");
        const auto pictures = static_cast<std::uint32_t>(tables.picture_bytes.size());
        put_movie_header(bytes, static_cast<std::uint32_t>(track.pictures_per_s), pictures);
        const Mp4Box box(bytes, "trak");
        put_track_header(bytes, track, pictures);
        put_media(bytes, track, tables);
    }
    // In an MP4 box, a length of 1 in the first 32 bits means that the real length follows as a 64-bit
    // number.
    const bool is_large = data_bytes + 8 > u32_max;
    bytes.u32(is_large ? 1 : static_cast<std::uint32_t>(data_bytes + 8));
    bytes.text("mdat");
    if (is_large) bytes.u64(data_bytes + 16);
    return bytes;
}

// Reads or writes all the bytes with repeated calls of `call`, which is pread or pwrite. The function returns
// the error number (errno), or 0 for success.
template <class Call, class Byte>
int transfer(Call call, int file, std::span<Byte> bytes, std::uint64_t place)
{
    while (!bytes.empty()) {
        const ssize_t count = call(file, bytes.data(), bytes.size(), static_cast<off_t>(place));
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return count < 0 ? errno : EIO;
        bytes = bytes.subspan(static_cast<std::size_t>(count));
        place += static_cast<std::uint64_t>(count);
    }
    return 0;
}

// Moves the file's first `count` bytes towards the end by `distance` bytes. The last block moves first, so
// that no byte is overwritten before it was read.
int move_back(int file, std::uint64_t count, std::uint64_t distance)
{
    std::vector<std::uint8_t> block(moved_bytes_max);
    int error_number = 0;
    while (count > 0 && error_number == 0) {
        const auto part = static_cast<std::size_t>(std::min<std::uint64_t>(count, block.size()));
        count -= part;
        const std::span<std::uint8_t> bytes(block.data(), part);
        error_number = transfer(::pread, file, bytes, count);
        if (error_number == 0) error_number = transfer(::pwrite, file, bytes, count + distance);
    }
    return error_number;
}

} // namespace

bool Mp4Index::add(std::uint32_t bytes, bool is_key)
{
    if (picture_bytes_.size() >= pictures_max) return false;
    picture_bytes_.push_back(bytes);
    data_bytes_ += bytes;
    if (is_key) keys_.push_back(static_cast<std::uint32_t>(picture_bytes_.size()));
    return true;
}

// The length of the index at the file's beginning depends only on whether its positions have 32 or 64 bits,
// and not on their values.
std::vector<std::uint8_t> Mp4Index::head(const Mp4Track &track) const
{
    Mp4Tables tables{picture_bytes_, keys_, 0, false};
    tables.is_wide = make_head(track, tables, data_bytes_).bytes.size() + data_bytes_ > u32_max;
    tables.begin = make_head(track, tables, data_bytes_).bytes.size();
    return std::move(make_head(track, tables, data_bytes_).bytes);
}

void Mp4File::add(std::span<const std::uint8_t> picture, bool is_key)
{
    if (picture.size() > u32_max || !index_.add(static_cast<std::uint32_t>(picture.size()), is_key))
        throw OutputError(file_.path() + ": a film has at most " + std::to_string(Mp4Index::pictures_max) +
                          " pictures of at most 4 GiB each; end it sooner");
    file_.write(picture.data(), picture.size());
}

void Mp4File::commit(const Mp4Track &track)
{
    std::FILE *stream = file_.stream();
    if (std::fflush(stream) != 0) throw OutputError(file_.path(), errno);
    const std::vector<std::uint8_t> head = index_.head(track);
    const int file = ::fileno(stream);
    int error_number = move_back(file, index_.data_bytes(), head.size());
    if (error_number == 0) error_number = transfer(::pwrite, file, std::span(head), 0);
    if (error_number != 0) throw OutputError(file_.path(), error_number);
    file_.commit();
}

} // namespace crn
