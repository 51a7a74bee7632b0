#include "host/base/text.hpp"
#include "host/session/recording_format.hpp"
#include "shared/wire/wire_frame.h"
#include <algorithm>
#include <array>
#include <optional>

namespace crn
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
        if (bytes_.size() < 8 || (!std::equal(magic, magic + 7, bytes_.begin()) &&
                                  !std::equal(earlier_magic, earlier_magic + 7, bytes_.begin()))) {
            fail(RecordingFault::not_a_recording, "is not a Cournand recording");
        }
        const auto version = static_cast<char>(bytes_[7]);
        if (version < oldest_version || version > magic[7]) {
            fail(RecordingFault::newer_version, std::string("is a recording of version '") + version +
                                                    "', this program reads '" + oldest_version + "' to '" +
                                                    magic[7] +
                                                    "'; use the program that wrote it or a newer one");
        }
        position_ = 8;
    }

    // False at the end, or where the file was cut off. Damage is another matter: it throws.
    bool next_chunk()
    {
        const std::size_t left = bytes_.size() - position_;
        if (left < chunk_head_bytes + chunk_tail_bytes) return false;
        crn_wire_reader head = crn_wire_reader_make(bytes_.data() + position_, left);
        kind_ = static_cast<std::uint32_t>(crn_wire_read(&head, 4));
        const std::size_t count = crn_wire_read(&head, 4);
        if (kind_ < HEAD || kind_ > BALLOON)
            fail(RecordingFault::damaged, "is damaged: unknown chunk kind " + std::to_string(kind_));
        if (!is_size_of(kind_, count, recording_.header.tools.size()))
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

    void read_head()
    {
        RecordingHeader &header = recording_.header;
        header.core_version = static_cast<std::uint32_t>(crn_wire_read(&payload_, 4));
        header.schema_hash = crn_wire_read(&payload_, 8);
        if (header.schema_hash != crn_wire_schema_hash()) {
            char text[160];
            std::snprintf(text, sizeof text,
                          "was written with another wire schema (file %016llx, program %016llx); use the "
                          "release that wrote it",
                          static_cast<unsigned long long>(header.schema_hash),
                          static_cast<unsigned long long>(crn_wire_schema_hash()));
            fail(RecordingFault::newer_version, text);
        }
        header.scene_bytes = static_cast<std::uint32_t>(crn_wire_read(&payload_, 4));
        header.scene_crc32 = static_cast<std::uint32_t>(crn_wire_read(&payload_, 4));
        header.scene_path = get_text(payload_);
        header.session_path = get_text(payload_);
        const std::size_t tools = crn_wire_read(&payload_, 1);
        if (tools < 1 || tools > CRN_WIRE_TOOL_MAX)
            fail(RecordingFault::inconsistent, "is inconsistent: it has " + std::to_string(tools) + " tools");
        for (std::size_t k = 0; k < tools && !payload_.failed; k++) header.tools.push_back(read_tool());
        crn_wire_get_entry(&payload_, &header.entry);
        crn_wire_get_rig(&payload_, &header.rig);
        check_used_up("header");
        if (header.entry.inserted_um_count != tools)
            fail(RecordingFault::inconsistent, "is inconsistent: another number of lengths than tools");
    }

    Instrument read_tool()
    {
        Instrument tool;
        tool.name = get_text(payload_);
        tool.length_m = get_double(payload_);
        crn_wire_get_instrument(&payload_, &tool.table);
        const std::size_t count = crn_wire_read(&payload_, 2);
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

    std::uint32_t read_tick() { return static_cast<std::uint32_t>(crn_wire_read(&payload_, 4)); }

    void read_chunk()
    {
        switch (kind_) {
        case TICKS:
            read_ticks();
            break;
        case HASH: {
            const std::uint32_t tick = read_tick();
            recording_.hashes.push_back({tick, crn_wire_read(&payload_, 8)});
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
        case ROOM:
            read_command();
            break;
        case SIDE_HOLES:
            read_side_holes();
            break;
        case STENT:
            read_stent();
            break;
        case BALLOON:
            read_balloon();
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
            crn_wire_get_encoders(&payload_, &tick.input);
            if (tick.input.hands_count != recording_.header.tools.size())
                fail(RecordingFault::inconsistent, "is inconsistent: another number of hands than tools");
            tick.hash_lane[0] = static_cast<std::uint32_t>(crn_wire_read(&payload_, 4));
            tick.hash_lane[1] = static_cast<std::uint32_t>(crn_wire_read(&payload_, 4));
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
        return crn_wire_i32_from_u32(static_cast<std::uint32_t>(crn_wire_read(&payload_, 4)));
    }

    // Version 2: the whole view at once. Only what differs from the view before becomes a command.
    void read_view()
    {
        const std::uint32_t tick = read_tick();
        std::array<std::int32_t, 8> view{};
        view[0] = crn_wire_read(&payload_, 1) != 0;
        view[1] = crn_wire_read(&payload_, 1) != 0;
        for (std::size_t i = 2; i < view.size(); i++) view[i] = read_i32();
        check_used_up("view");
        const auto is_new = [&](std::size_t from, std::size_t to) {
            return !last_view_ ||
                   !std::equal(view.begin() + from, view.begin() + to, last_view_->begin() + from);
        };
        if (is_new(2, 4)) take_command(tick, {RoomAction::angles, {view[2], view[3], 0}});
        if (is_new(7, 8)) take_command(tick, {RoomAction::field, {view[7], 0, 0}});
        if (is_new(1, 2) || is_new(4, 7)) {
            take_command(tick, {RoomAction::table, {view[4], view[5], view[6]}});
            take_command(tick, {RoomAction::follow, {view[1], 0, 0}});
        }
        if (is_new(0, 1)) take_command(tick, {RoomAction::fluoro_pedal, {view[0], 0, 0}});
        last_view_ = view;
    }

    void read_command()
    {
        const std::uint32_t tick = read_tick();
        RoomCommand command;
        command.action = static_cast<RoomAction>(crn_wire_read(&payload_, 2));
        for (std::int32_t &value : command.values) value = read_i32();
        check_used_up("room");
        take_command(tick, command);
    }

    void read_side_holes()
    {
        const std::size_t tool = crn_wire_read(&payload_, 1);
        SideHoles holes;
        holes.arc_begin_m = get_double(payload_);
        holes.arc_end_m = get_double(payload_);
        holes.count = static_cast<std::uint32_t>(crn_wire_read(&payload_, 4));
        holes.diameter_m = get_double(payload_);
        check_used_up("side holes");
        const bool is_possible = tool < recording_.header.tools.size() && holes.arc_begin_m >= 0.0 &&
                                 holes.arc_end_m >= holes.arc_begin_m &&
                                 holes.arc_end_m < side_holes_end_max_m && holes.count >= 1 &&
                                 holes.count <= side_holes_max && holes.diameter_m > 0.0 &&
                                 holes.diameter_m < side_hole_diameter_max_m;
        if (!is_possible || recording_.header.tools[tool].side_holes.size() >= side_holes_max)
            fail(RecordingFault::inconsistent, "is inconsistent: side holes that no tool can have");
        recording_.header.tools[tool].side_holes.push_back(holes);
    }

    void read_balloon()
    {
        const std::size_t tool = crn_wire_read(&payload_, 1);
        BalloonLabel label;
        label.nominal_kPa = get_double(payload_);
        label.rated_burst_kPa = get_double(payload_);
        label.crossing_profile_m = get_double(payload_);
        const std::size_t markers = std::min<std::size_t>(crn_wire_read(&payload_, 1), balloon_markers_max);
        for (std::size_t i = 0; i < markers; i++) label.marker_arcs_m.push_back(get_double(payload_));
        check_used_up("balloon");
        const auto is_within = [](double value, double most) { return value >= 0.0 && value <= most; };
        const bool is_possible =
            tool < recording_.header.tools.size() && !recording_.header.tools[tool].balloon &&
            is_within(label.nominal_kPa, balloon_max_kPa) &&
            is_within(label.rated_burst_kPa, balloon_max_kPa) &&
            is_within(label.crossing_profile_m, balloon_profile_max_m) &&
            std::all_of(label.marker_arcs_m.begin(), label.marker_arcs_m.end(),
                        [&](double arc_m) { return is_within(arc_m, balloon_marker_max_m); });
        if (!is_possible)
            fail(RecordingFault::inconsistent, "is inconsistent: a balloon that no tool can have");
        recording_.header.tools[tool].balloon = label;
    }

    void read_stent()
    {
        StentDesign stent;
        stent.name = get_text(payload_);
        stent.material = get_text(payload_);
        stent.connection =
            crn_wire_read(&payload_, 1) != 0 ? StentConnection::facing : StentConnection::offset;
        for (const StentCount &row : stent_counts()) stent.*row.value = read_i32();
        for (const StentNumber &row : stent_numbers()) stent.*row.value = get_double(payload_);
        check_used_up("stent");
        if (!is_possible(stent) || recording_.header.stents.size() >= recorded_stents_max)
            fail(RecordingFault::inconsistent, "is inconsistent: a stent that cannot be");
        recording_.header.stents.push_back(stent);
    }

    void take_command(std::uint32_t tick, const RoomCommand &command)
    {
        const std::string why = refusal(command);
        if (!why.empty())
            fail(RecordingFault::inconsistent, "is inconsistent: the room cannot do this: " + why);
        if (!recording_.commands.empty() && tick < recording_.commands.back().tick)
            fail(RecordingFault::inconsistent, "is inconsistent: commands to the room are out of order");
        recording_.commands.push_back({tick, command});
    }

    void read_end()
    {
        const std::uint32_t tick = read_tick();
        const std::uint64_t hash = crn_wire_read(&payload_, 8);
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
    crn_wire_reader payload_{};
    std::optional<std::array<std::int32_t, 8>> last_view_; // fluoro, follow, angles, table, field
    Recording recording_;
};

} // namespace

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

} // namespace crn
