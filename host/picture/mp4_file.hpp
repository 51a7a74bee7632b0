// Writes an MP4 file with one H.264 film track (ISO/IEC 14496-12, -14 and -15). The index of the file comes
// before the pictures, so that a player can begin before it has received the whole file. The contents of the
// file do not depend on the date or time, so equal pictures give equal bytes.
#pragma once
#include "host/base/pending_file.hpp"
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace crn
{

struct Mp4Track {
    int width = 0;          // pixels, 1 .. 65535
    int height = 0;         // pixels, 1 .. 65535
    int pictures_per_s = 0; // 1 .. 65535, also the number of units in a second of the file's clock
    std::vector<std::uint8_t> sequence_parameters; // H.264 SPS without a start code, 4 .. 65535 bytes
    std::vector<std::uint8_t> picture_parameters;  // H.264 PPS without a start code, 1 .. 65535 bytes
};

// Holds the data about each picture that the file's index needs, in 4 bytes of memory per picture.
class Mp4Index
{
  public:
    // At 60 pictures per second, 2^28 pictures last 51 days, which is longer than the longest possible
    // session.
    static constexpr std::size_t pictures_max = std::size_t{1} << 28;

    // Adds a picture to the index; returns false when the index already holds pictures_max pictures.
    bool add(std::uint32_t bytes, bool is_key);
    std::size_t pictures() const { return picture_bytes_.size(); }
    std::uint64_t data_bytes() const { return data_bytes_; }
    // Returns all bytes that come before the first picture: file type, index, and the beginning of the box
    // with the pictures.
    std::vector<std::uint8_t> head(const Mp4Track &track) const;

  private:
    std::vector<std::uint32_t> picture_bytes_;
    std::vector<std::uint32_t> keys_; // from 1
    std::uint64_t data_bytes_ = 0;
};

// Every picture is written to a temporary file at once. commit() then moves the pictures towards the file's
// end by the length of the index, block by block, and writes the index before them. Every function throws
// OutputError when writing fails; the destructor deletes a file that was not committed.
class Mp4File
{
  public:
    explicit Mp4File(const std::string &path) : file_(path) {}
    // Adds one picture: its NAL units, each preceded by its length (4 bytes, most significant byte first).
    void add(std::span<const std::uint8_t> picture, bool is_key);
    void commit(const Mp4Track &track);

  private:
    PendingFile file_;
    Mp4Index index_;
};

} // namespace crn
