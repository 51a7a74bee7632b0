#include "host/base/format.hpp"
#include "host/base/text.hpp"
#include "host/session/recording_chunks.hpp"
#include "host/session/recording_format.hpp"
#include <algorithm>

namespace crn
{

using namespace recording_format;

namespace
{

constexpr std::uint32_t ticks_max = 1u << 26; // 18 hours

// Reads the recording chunk by chunk, and remembers its position for error messages.
class Reader
{
  public:
    Reader(std::span<const std::uint8_t> bytes, const std::string &name)
        : name_(name), mark_(version_of(bytes)), chunks_(bytes, name), payload_(chunks_.payload())
    {
    }

    Recording read()
    {
        check_version();
        chunks_.read_head(present_rules);
        read_head();
        while (!recording_.is_complete && chunks_.next(present_rules, recording_.header.positions()))
            read_chunk();
        if (recording_.is_complete && !chunks_.is_at_end())
            fail(RecordingFault::damaged, "has bytes behind its end");
        return std::move(recording_);
    }

  private:
    [[noreturn]] void fail(RecordingFault fault, const std::string &text) const { chunks_.fail(fault, text); }

    void check_version()
    {
        if (!mark_.is_recording) fail(RecordingFault::not_a_recording, "is not a Cournand recording");
        if (mark_.is_older)
            fail(RecordingFault::older_version,
                 std::string("is a recording of version '") + mark_.version + "', this program reads '" +
                     magic[7] + "'; convert it: cournand replay --upgrade " + name_ + " -o NEW.rec");
        if (!mark_.is_present)
            fail(RecordingFault::newer_version,
                 std::string("is a recording of version '") + mark_.version + "', this program reads '" +
                     magic[7] + "' and converts '" + oldest_version + "' to '" +
                     static_cast<char>(magic[7] - 1) + "'; use the program that wrote it or a newer one");
    }

    void read_head()
    {
        RecordingHeader &header = recording_.header;
        header.core_version = static_cast<std::uint32_t>(crn_wire_read(&payload_, 4));
        header.schema_hash = crn_wire_read(&payload_, 8);
        if (header.schema_hash != crn_wire_schema_hash()) {
            const std::string text =
                formatted("was written with another wire schema (file %016llx, program %016llx); use the "
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
        if (tools < 1 || tools > CRN_WIRE_TABLE_MAX)
            fail(RecordingFault::inconsistent, "is inconsistent: it has " + std::to_string(tools) + " tools");
        for (std::size_t k = 0; k < tools && !payload_.failed; k++) header.tools.push_back(read_tool());
        read_line();
        crn_wire_get_entry(&payload_, &header.entry);
        crn_wire_get_rig(&payload_, &header.rig);
        check_used_up("header");
        if (header.entry.inserted_um_count != header.positions())
            fail(RecordingFault::inconsistent, "is inconsistent: another number of lengths than tools");
    }

    // Each tool is in use at most once, and at least one tool is in use.
    void read_line()
    {
        RecordingHeader &header = recording_.header;
        const std::size_t positions = crn_wire_read(&payload_, 1);
        std::uint32_t seen_bits = 0;
        bool is_possible = positions <= CRN_WIRE_TOOL_MAX;
        for (std::size_t k = 0; k < positions && is_possible && !payload_.failed; k++) {
            header.line.push_back(static_cast<std::uint8_t>(crn_wire_read(&payload_, 1)));
            const std::uint8_t number = header.line.back();
            is_possible = number <= header.tools.size() && (number == 0 || (seen_bits >> number & 1u) == 0);
            if (is_possible) seen_bits |= 1u << number;
        }
        if (!is_possible || (positions > 0 && seen_bits < 2) || header.positions() > CRN_WIRE_TOOL_MAX)
            fail(RecordingFault::inconsistent, "is inconsistent: a line that cannot be");
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

    void check_used_up(const char *what) const { chunks_.check_used_up(what); }
    std::uint32_t read_tick() { return chunks_.read_u32(); }
    std::int32_t read_i32() { return chunks_.read_i32(); }

    void read_chunk()
    {
        switch (chunks_.kind()) {
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
        const std::size_t tools = recording_.header.positions(), bytes = payload_.length - payload_.position;
        if (first != recording_.ticks.size() || count > ticks_max - first ||
            bytes < count * tick_bytes_min(tools) || bytes > count * tick_bytes_max(tools)) {
            fail(RecordingFault::inconsistent, "is inconsistent: ticks are missing or doubled");
        }
        for (std::uint32_t i = 0; i < count; i++) {
            RecordedTick tick;
            if (!crn_wire_get_tick_input(&payload_, &tick.input)) break;
            if (tick.input.hands_count != tools)
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

    const std::string &name_;
    const VersionMark mark_;
    ChunkReader chunks_;
    crn_wire_reader &payload_;
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
    const RecordedSnapshot *last = nullptr; // several may have the same tick, if the device disappeared again
                                            // before its next tick
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

std::vector<std::uint8_t> read_recording_bytes(const std::string &path)
{
    try {
        return read_binary_file(path);
    } catch (const FileError &error) {
        throw RecordingError(RecordingFault::unreadable, error.what());
    }
}

Recording read_recording(const std::string &path)
{
    return parse_recording(read_recording_bytes(path), path);
}

} // namespace crn
