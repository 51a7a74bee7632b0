#include "host/app/recording_format.hpp"
#include "host/model/text.hpp"
#include "shared/wire/wire_frame.h"
#include <algorithm>

namespace seld
{

using namespace recording_format;

namespace
{

constexpr std::uint32_t ticks_max = 1u << 26; // 18 hours

// Reads chunk after chunk; knows where it is for the message.
class Reader
{
  public:
    Reader(std::span<const std::uint8_t> bytes, const std::string &name) : bytes_(bytes), name_(name) {}

    Recording read()
    {
        check_magic();
        if (!next_chunk()) fail(RecordingFault::truncated, "ends within its header");
        if (kind_ != HEAD) fail(RecordingFault::damaged, "does not begin with a header");
        read_head();
        while (!recording_.is_complete && next_chunk()) read_chunk();
        if (recording_.is_complete && position_ != bytes_.size()) {
            fail(RecordingFault::damaged, "has bytes behind its end");
        }
        return std::move(recording_);
    }

  private:
    [[noreturn]] void fail(RecordingFault fault, const std::string &text) const
    {
        throw RecordingError(fault, name_ + ": " + text + " (at byte " + std::to_string(position_) + ")");
    }

    void check_magic()
    {
        if (bytes_.size() < 8 || !std::equal(magic, magic + 7, bytes_.begin())) {
            fail(RecordingFault::not_a_recording, "is not a Seldinger recording");
        }
        if (bytes_[7] != static_cast<std::uint8_t>(magic[7])) {
            fail(RecordingFault::newer_version, std::string("is a recording of version '") +
                                                    static_cast<char>(bytes_[7]) +
                                                    "', this program reads version '" + magic[7] +
                                                    "'; use the program that wrote it or a newer one");
        }
        position_ = 8;
    }

    // False at the end, or where the file was cut off. Damage is another matter: it throws.
    bool next_chunk()
    {
        const std::size_t left = bytes_.size() - position_;
        if (left < chunk_head_bytes + chunk_tail_bytes) return false;
        seld_wire_reader head = seld_wire_reader_make(bytes_.data() + position_, left);
        kind_ = static_cast<std::uint32_t>(seld_wire_read(&head, 4));
        const std::size_t count = seld_wire_read(&head, 4);
        if (kind_ < HEAD || kind_ > RESUMED)
            fail(RecordingFault::damaged, "is damaged: unknown chunk kind " + std::to_string(kind_));
        if (count > left - chunk_head_bytes - chunk_tail_bytes) return false;
        const std::size_t covered = chunk_head_bytes + count;
        seld_wire_reader tail = seld_wire_reader_make(bytes_.data() + position_ + covered, chunk_tail_bytes);
        if (seld_wire_crc32(0, bytes_.data() + position_, covered) != seld_wire_read(&tail, 4)) {
            fail(RecordingFault::damaged, "is damaged: the checksum of a chunk does not match");
        }
        payload_ = seld_wire_reader_make(bytes_.data() + position_ + chunk_head_bytes, count);
        position_ += covered + chunk_tail_bytes;
        return true;
    }

    void read_head()
    {
        RecordingHeader &header = recording_.header;
        header.core_version = static_cast<std::uint32_t>(seld_wire_read(&payload_, 4));
        header.schema_hash = seld_wire_read(&payload_, 8);
        if (header.schema_hash != seld_wire_schema_hash()) {
            char text[160];
            std::snprintf(text, sizeof text,
                          "was written with another wire schema (file %016llx, program %016llx); use the "
                          "release that wrote it",
                          static_cast<unsigned long long>(header.schema_hash),
                          static_cast<unsigned long long>(seld_wire_schema_hash()));
            fail(RecordingFault::newer_version, text);
        }
        header.scene_bytes = static_cast<std::uint32_t>(seld_wire_read(&payload_, 4));
        header.scene_crc32 = static_cast<std::uint32_t>(seld_wire_read(&payload_, 4));
        header.scene_path = get_text(payload_);
        header.session_path = get_text(payload_);
        const std::size_t tools = seld_wire_read(&payload_, 1);
        if (tools < 1 || tools > SELD_WIRE_TOOL_MAX)
            fail(RecordingFault::inconsistent, "is inconsistent: it has " + std::to_string(tools) + " tools");
        for (std::size_t k = 0; k < tools && !payload_.failed; k++) header.tools.push_back(read_tool());
        seld_wire_get_entry(&payload_, &header.entry);
        seld_wire_get_rig(&payload_, &header.rig);
        check_used_up("header");
        if (header.entry.inserted_um_count != tools)
            fail(RecordingFault::inconsistent, "is inconsistent: another number of lengths than tools");
    }

    Instrument read_tool()
    {
        Instrument tool;
        tool.name = get_text(payload_);
        tool.length_m = get_double(payload_);
        seld_wire_get_instrument(&payload_, &tool.table);
        const std::size_t count = seld_wire_read(&payload_, 2);
        for (std::size_t i = 0; i < count && !payload_.failed; i++) {
            InstrumentLayer layer;
            layer.arc_begin_m = get_double(payload_);
            layer.arc_end_m = get_double(payload_);
            layer.material = get_text(payload_);
            layer.fill = get_double(payload_);
            layer.radius_share = get_double(payload_);
            tool.layers.push_back(layer);
        }
        return tool;
    }

    void check_used_up(const char *what) const
    {
        if (payload_.failed || payload_.position != payload_.length) {
            fail(RecordingFault::inconsistent,
                 std::string("is inconsistent: a ") + what + " chunk does not have its form");
        }
    }

    std::uint32_t read_tick() { return static_cast<std::uint32_t>(seld_wire_read(&payload_, 4)); }

    void read_chunk()
    {
        switch (kind_) {
        case TICKS:
            read_ticks();
            break;
        case HASH: {
            const std::uint32_t tick = read_tick();
            recording_.hashes.push_back({tick, seld_wire_read(&payload_, 8)});
            check_used_up("hash");
            break;
        }
        case SNAPSHOT:
            read_snapshot(recording_.snapshots);
            break;
        case RESUMED:
            read_snapshot(recording_.resumes);
            break;
        case VIEW:
            read_view();
            break;
        case END:
            read_end();
            break;
        default:
            fail(RecordingFault::damaged, "has a second header");
        }
    }

    void read_ticks()
    {
        const std::uint32_t first = read_tick();
        const std::uint32_t count = read_tick();
        if (first != recording_.ticks.size() || count > ticks_max - first ||
            payload_.length - payload_.position != count * tick_bytes(recording_.header.tools.size())) {
            fail(RecordingFault::inconsistent, "is inconsistent: ticks are missing or doubled");
        }
        for (std::uint32_t i = 0; i < count; i++) {
            RecordedTick tick;
            seld_wire_get_encoders(&payload_, &tick.input);
            if (tick.input.hands_count != recording_.header.tools.size())
                fail(RecordingFault::inconsistent, "is inconsistent: another number of hands than tools");
            tick.hash_lane[0] = static_cast<std::uint32_t>(seld_wire_read(&payload_, 4));
            tick.hash_lane[1] = static_cast<std::uint32_t>(seld_wire_read(&payload_, 4));
            recording_.ticks.push_back(tick);
        }
        check_used_up("ticks");
    }

    void read_snapshot(std::vector<RecordedSnapshot> &snapshots)
    {
        const std::uint32_t tick = read_tick();
        if (tick != recording_.ticks.size())
            fail(RecordingFault::inconsistent, "is inconsistent: a snapshot is out of place");
        const std::uint8_t *begin = payload_.bytes + payload_.position;
        snapshots.push_back({tick, {begin, payload_.bytes + payload_.length}});
    }

    std::int32_t read_i32()
    {
        return seld_wire_i32_from_u32(static_cast<std::uint32_t>(seld_wire_read(&payload_, 4)));
    }

    void read_view()
    {
        RecordedView recorded;
        recorded.tick = read_tick();
        recorded.view.is_fluoro_on = seld_wire_read(&payload_, 1) != 0;
        recorded.view.follows_tip = seld_wire_read(&payload_, 1) != 0;
        recorded.view.primary_mdeg = read_i32();
        recorded.view.secondary_mdeg = read_i32();
        for (std::int32_t &um : recorded.view.table_um) um = read_i32();
        recorded.view.field_um = read_i32();
        check_used_up("view");
        if (!recording_.views.empty() && recorded.tick < recording_.views.back().tick) {
            fail(RecordingFault::inconsistent, "is inconsistent: views are out of order");
        }
        recording_.views.push_back(recorded);
    }

    void read_end()
    {
        const std::uint32_t tick = read_tick();
        const std::uint64_t hash = seld_wire_read(&payload_, 8);
        check_used_up("end");
        if (tick != recording_.ticks.size())
            fail(RecordingFault::inconsistent, "is inconsistent: its end names another number of ticks");
        recording_.hashes.push_back({tick, hash});
        recording_.is_complete = true;
    }

    std::span<const std::uint8_t> bytes_;
    const std::string &name_;
    std::size_t position_ = 0;
    std::uint32_t kind_ = 0;
    seld_wire_reader payload_{};
    Recording recording_;
};

} // namespace

const ViewState &Recording::view_at(std::uint32_t tick) const
{
    static const ViewState none;
    const ViewState *view = &none;
    for (const RecordedView &recorded : views) {
        if (recorded.tick > tick) break;
        view = &recorded.view;
    }
    return *view;
}

const RecordedSnapshot *Recording::snapshot_before(std::uint32_t tick) const
{
    const RecordedSnapshot *best = nullptr;
    for (const RecordedSnapshot &snapshot : snapshots) {
        if (snapshot.tick <= tick) best = &snapshot;
    }
    return best;
}

const RecordedSnapshot *Recording::resumed_at(std::uint32_t tick) const
{
    const RecordedSnapshot *last = nullptr; // of several at one tick: the device went again before it did any
    for (const RecordedSnapshot &resume : resumes) {
        if (resume.tick == tick) last = &resume;
    }
    return last;
}

std::uint32_t Recording::ticks_to_resume(std::uint32_t tick) const
{
    std::uint32_t left = UINT32_MAX;
    for (const RecordedSnapshot &resume : resumes) {
        if (resume.tick > tick) left = std::min(left, resume.tick - tick);
    }
    return left;
}

Recording parse_recording(std::span<const std::uint8_t> bytes, const std::string &name)
{
    return Reader(bytes, name).read();
}

Recording read_recording(const std::string &path)
{
    std::vector<unsigned char> bytes;
    try {
        bytes = read_binary_file(path);
    } catch (const FileError &error) {
        throw RecordingError(RecordingFault::unreadable, error.what());
    }
    return parse_recording(bytes, path);
}

} // namespace seld
