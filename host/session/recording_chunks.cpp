#include "host/session/recording_chunks.hpp"
#include "host/session/recording_format.hpp"
#include "shared/wire/wire_frame.h"
#include <algorithm>

namespace crn::recording_format
{

namespace
{

// Recordings from before the project was renamed begin with this magic text, but otherwise have the same
// format as later recordings.
constexpr char earlier_magic[8] = "\x53\x45\x4c\x44REC";

bool is_known(std::uint32_t kind)
{
    return kind >= HEAD && kind <= BALLOON && kind != VIEW;
}

} // namespace

const ChunkRules present_rules = {is_known, is_size_of};

VersionMark version_of(std::span<const std::uint8_t> bytes)
{
    VersionMark mark;
    if (bytes.size() < 8) return mark;
    const bool is_ours = std::equal(magic, magic + 7, bytes.begin());
    const bool is_earlier = std::equal(earlier_magic, earlier_magic + 7, bytes.begin());
    mark.is_recording = is_ours || is_earlier;
    mark.version = static_cast<char>(bytes[7]);
    mark.is_present = is_ours && mark.version == magic[7];
    mark.is_older = mark.is_recording && mark.version >= oldest_version && mark.version < magic[7];
    return mark;
}

std::vector<std::uint8_t> sealed_chunk(std::uint32_t kind, std::span<const std::uint8_t> payload)
{
    std::vector<std::uint8_t> bytes(chunk_head_bytes + payload.size() + chunk_tail_bytes);
    crn_wire_writer writer = crn_wire_writer_make(bytes.data(), bytes.size());
    crn_wire_write(&writer, kind, 4);
    crn_wire_write(&writer, payload.size(), 4);
    std::copy(payload.begin(), payload.end(), bytes.begin() + chunk_head_bytes);
    writer.length += payload.size();
    crn_wire_write(&writer, crn_wire_crc32(0, bytes.data(), writer.length), 4);
    return bytes;
}

void ChunkReader::fail(RecordingFault fault, const std::string &text) const
{
    throw RecordingError(fault, name_ + ": " + text + " (at byte " + std::to_string(position_) + ")");
}

void ChunkReader::read_head(const ChunkRules &rules)
{
    position_ = 8; // behind the version
    if (!next(rules, 0)) fail(RecordingFault::truncated, "ends within its header");
    if (kind_ != HEAD) fail(RecordingFault::damaged, "does not begin with a header");
}

bool ChunkReader::next(const ChunkRules &rules, std::size_t tool_count)
{
    const std::size_t left = bytes_.size() - position_;
    if (left < chunk_head_bytes + chunk_tail_bytes) return false;
    crn_wire_reader head = crn_wire_reader_make(bytes_.data() + position_, left);
    kind_ = static_cast<std::uint32_t>(crn_wire_read(&head, 4));
    const std::size_t count = crn_wire_read(&head, 4);
    if (!rules.is_known(kind_))
        fail(RecordingFault::damaged, "is damaged: unknown chunk kind " + std::to_string(kind_));
    if (!rules.is_size_of(kind_, count, tool_count))
        fail(RecordingFault::damaged, "is damaged: a chunk of kind " + std::to_string(kind_) +
                                          " cannot have " + std::to_string(count) + " bytes");
    if (count > left - chunk_head_bytes - chunk_tail_bytes) return false;
    const std::size_t covered = chunk_head_bytes + count;
    crn_wire_reader tail = crn_wire_reader_make(bytes_.data() + position_ + covered, chunk_tail_bytes);
    if (crn_wire_crc32(0, bytes_.data() + position_, covered) != crn_wire_read(&tail, 4)) {
        fail(RecordingFault::damaged, "is damaged: the checksum of a chunk does not match");
    }
    payload_ = crn_wire_reader_make(bytes_.data() + position_ + chunk_head_bytes, count);
    position_ += covered + chunk_tail_bytes;
    return true;
}

void ChunkReader::check_used_up(const char *what) const
{
    if (payload_.failed || payload_.position != payload_.length) {
        fail(RecordingFault::inconsistent,
             std::string("is inconsistent: a ") + what + " chunk does not have its form");
    }
}

} // namespace crn::recording_format
