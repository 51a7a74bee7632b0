// Reads the chunks of a recording in order; both the reader and the converter of older versions use this
// class.
#pragma once
#include "host/session/recording.hpp"
#include <span>
#include <string>
#include <vector>

namespace crn::recording_format
{

// `is_size_of` returns true if a chunk of this kind can have this number of bytes. An impossible length of a
// chunk means that the file was damaged, and not merely cut off. `is_known` returns true if recordings of
// this version have chunks of this kind.
struct ChunkRules {
    bool (*is_known)(std::uint32_t kind);
    bool (*is_size_of)(std::uint32_t kind, std::size_t bytes, std::size_t tool_count);
};
extern const ChunkRules present_rules;

// Holds the contents of the bytes before the first chunk: the magic text and the version.
struct VersionMark {
    bool is_recording = false;
    char version = 0;
    bool is_present = false; // the version that this program writes and reads
    bool is_older = false;   // one that it can convert
};
VersionMark version_of(std::span<const std::uint8_t> bytes);

// Head, payload and checksum.
std::vector<std::uint8_t> sealed_chunk(std::uint32_t kind, std::span<const std::uint8_t> payload);

class ChunkReader
{
  public:
    // `bytes` and `name` must live longer than this object.
    ChunkReader(std::span<const std::uint8_t> bytes, const std::string &name) : bytes_(bytes), name_(name) {}

    // Throws RecordingError with a message that names the file and the position in bytes in it.
    [[noreturn]] void fail(RecordingFault fault, const std::string &text) const;
    // Reads the first chunk, which is the header of the recording. Throws RecordingError.
    void read_head(const ChunkRules &rules);
    // Reads the next chunk; returns false at the end of the file, and also where a file was cut off. Throws
    // RecordingError if the file is damaged.
    bool next(const ChunkRules &rules, std::size_t tool_count);
    bool is_at_end() const { return position_ == bytes_.size(); }
    void check_used_up(const char *what) const;

    std::uint32_t kind() const { return kind_; }
    crn_wire_reader &payload() { return payload_; }
    std::span<const std::uint8_t> payload_bytes() const { return {payload_.bytes, payload_.length}; }
    std::uint32_t read_u32() { return static_cast<std::uint32_t>(crn_wire_read(&payload_, 4)); }
    std::int32_t read_i32() { return crn_wire_i32_from_u32(read_u32()); }

  private:
    std::span<const std::uint8_t> bytes_;
    const std::string &name_;
    std::size_t position_ = 0;
    std::uint32_t kind_ = 0;
    crn_wire_reader payload_{};
};

} // namespace crn::recording_format
