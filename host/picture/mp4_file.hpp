// An MP4 file with one H.264 track (ISO/IEC 14496-12, -14 and -15). Its index comes before the pictures, so
// that a player can begin before it has the whole file. Nothing in it depends on the clock: the same pictures
// give the same bytes.
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

// What the index says about the pictures: 4 bytes of memory for each.
class Mp4Index
{
  public:
    // At 60 pictures per second this is 51 days, more than the ticks of a session can count.
    static constexpr std::size_t pictures_max = std::size_t{1} << 28;

    // False when the index already holds pictures_max.
    bool add(std::uint32_t bytes, bool is_key);
    std::size_t pictures() const { return picture_bytes_.size(); }
    std::uint64_t data_bytes() const { return data_bytes_; }
    // Everything that comes before the first picture: file type, index, and the head of the pictures' box.
    std::vector<std::uint8_t> head(const Mp4Track &track) const;

  private:
    std::vector<std::uint32_t> picture_bytes_;
    std::vector<std::uint32_t> keys_; // from 1
    std::uint64_t data_bytes_ = 0;
};

// Pictures go to the pending file as they come. commit() then moves them back by the length of the index,
// block by block, and writes the index before them. Every function throws OutputError; the destructor removes
// a file that was not committed.
class Mp4File
{
  public:
    explicit Mp4File(const std::string &path) : file_(path) {}
    // One picture: NAL units, each behind its length (4 bytes, big end first).
    void add(std::span<const std::uint8_t> picture, bool is_key);
    void commit(const Mp4Track &track);

  private:
    PendingFile file_;
    Mp4Index index_;
};

} // namespace crn
