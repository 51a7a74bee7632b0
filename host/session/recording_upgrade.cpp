#include "host/session/recording_upgrade.hpp"
#include "host/base/format.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/text.hpp"
#include "host/model/order_queue.hpp"
#include "host/session/recording_chunks.hpp"
#include "host/session/recording_format.hpp"
#include <algorithm>
#include <array>
#include <optional>

namespace crn
{

using namespace recording_format;

namespace
{

bool is_old_kind(std::uint32_t kind)
{
    return kind >= HEAD && kind <= BALLOON;
}

bool is_old_size(std::uint32_t kind, std::size_t bytes, std::size_t tool_count)
{
    if (kind == VIEW) return bytes == view_bytes;
    if (kind != TICKS) return is_size_of(kind, bytes, tool_count);
    return bytes >= 8 && (bytes - 8) % old_tick_bytes(tool_count) == 0 &&
           (bytes - 8) / old_tick_bytes(tool_count) <= Recorder::ticks_per_chunk;
}

constexpr ChunkRules old_rules = {is_old_kind, is_old_size};
constexpr ChunkRules protocol_5_rules = {is_old_kind, is_size_of}; // and of protocol 6

// When an old recording is upgraded, new data are inserted into a snapshot of protocol 4 or 5 at two kinds of
// places: after the 108 bytes of each of its three tools, and directly before its 388 nodes of 84 bytes each.
// A snapshot of protocol 6 lacks only the sets of the tools and the ways of the walls (crn_set_state of
// firmware/core/core_state.h, crn_wall_state), which lie before the nodes.
constexpr std::size_t snapshot_head_bytes = 12, snapshot_tool_bytes = 108, snapshot_tools = 3,
                      release_bytes = 12, node_bytes = std::size_t{388} * 84, exchange_words = 5,
                      set_bytes = 4 + snapshot_tools * 160 * 8, wall_bytes = 4 + 192 * 16;
constexpr std::uint32_t protocol_5_snapshot_version = 3, protocol_6_snapshot_version = 4,
                        snapshot_version = 5;

// Protocol 6 added two lengths to the record of a tool, and protocol 7 the material. An old tool is elastic,
// and its lengths are not known, so the added bytes are 0.
constexpr std::size_t length_bytes = 2 * 4, material_bytes = 1 + 5 * 4;

// Appends a word in little-endian byte order.
void put_word(std::vector<std::uint8_t> &bytes, std::uint32_t value)
{
    for (unsigned i = 0; i < 4; i++) bytes.push_back(static_cast<std::uint8_t>(value >> 8 * i));
}

class Upgrade
{
  public:
    Upgrade(std::span<const std::uint8_t> bytes, const std::string &name)
        : chunks_(bytes, name), mark_(version_of(bytes))
    {
    }

    std::vector<std::uint8_t> run()
    {
        check_version();
        bytes_.assign(magic, magic + 8);
        const ChunkRules &rules = has_order_lists() ? protocol_5_rules : old_rules;
        chunks_.read_head(rules);
        take_head();
        bool is_complete = false;
        while (!is_complete && chunks_.next(rules, positions_)) {
            is_complete = chunks_.kind() == END;
            take_chunk();
        }
        if (is_complete && !chunks_.is_at_end())
            chunks_.fail(RecordingFault::damaged, "has bytes behind its end");
        return std::move(bytes_);
    }

  private:
    void check_version() const
    {
        if (!mark_.is_recording) chunks_.fail(RecordingFault::not_a_recording, "is not a Cournand recording");
        if (mark_.is_present)
            chunks_.fail(RecordingFault::newer_version,
                         "has this program's version already: replay it as it is");
        if (!mark_.is_older)
            chunks_.fail(RecordingFault::newer_version,
                         std::string("is a recording of version '") + mark_.version +
                             "', this program converts '" + oldest_version + "' to '" +
                             static_cast<char>(magic[7] - 1) + "'; use the program that wrote it");
    }

    bool is_protocol_6() const { return mark_.version == protocol_6_version; }
    bool has_order_lists() const { return is_protocol_6() || mark_.version == protocol_5_version; }

    void add(std::uint32_t kind, std::span<const std::uint8_t> payload)
    {
        const std::vector<std::uint8_t> chunk = sealed_chunk(kind, payload);
        bytes_.insert(bytes_.end(), chunk.begin(), chunk.end());
    }

    // The header of the recording changes in three places: the schema hash, the values of each tool, and,
    // before protocol 6, the list of tools in use, which has all tools.
    void take_head()
    {
        crn_wire_reader &payload = chunks_.payload();
        crn_wire_read(&payload, 4);
        const std::size_t place = payload.position;
        check_schema(crn_wire_read(&payload, 8));
        crn_wire_read(&payload, 8); // of the scene
        get_text(payload);
        get_text(payload);
        const std::size_t tools = crn_wire_read(&payload, 1);
        if (payload.failed || tools < 1 || tools > (is_protocol_6() ? CRN_WIRE_TABLE_MAX : CRN_WIRE_TOOL_MAX))
            chunks_.fail(RecordingFault::inconsistent,
                         "is inconsistent: it has " + std::to_string(tools) + " tools");
        const auto old = chunks_.payload_bytes();
        std::vector<std::uint8_t> head(old.begin(),
                                       old.begin() + static_cast<std::ptrdiff_t>(payload.position));
        for (std::size_t k = 0; k < tools; k++) take_tool(head);
        positions_ = tools;
        if (is_protocol_6())
            take_line(head);
        else
            head.push_back(0);
        head.insert(head.end(), old.begin() + static_cast<std::ptrdiff_t>(payload.position), old.end());
        crn_wire_writer writer = crn_wire_writer_make(head.data() + place, 8);
        crn_wire_write(&writer, crn_wire_schema_hash(), 8);
        add(HEAD, head);
    }

    // The parser of the present version checks the line (the tools in use at the beginning).
    void take_line(std::vector<std::uint8_t> &head)
    {
        crn_wire_reader &payload = chunks_.payload();
        const std::size_t begin = payload.position, count = crn_wire_read(&payload, 1);
        skip(count);
        if (count > 0) positions_ = count;
        if (payload.failed || positions_ > CRN_WIRE_TOOL_MAX)
            chunks_.fail(RecordingFault::inconsistent, "is inconsistent: a line that cannot be");
        head.insert(head.end(), payload.bytes + begin, payload.bytes + payload.position);
    }

    void check_schema(std::uint64_t schema) const
    {
        const std::uint64_t known = is_protocol_6()     ? schema_of_protocol_6
                                    : has_order_lists() ? schema_of_protocol_5
                                                        : schema_of_protocol_4;
        if (schema == known) return;
        chunks_.fail(
            RecordingFault::newer_version,
            formatted("was written with another wire schema (file %016llx, converted is %016llx); use "
                      "the release that wrote it",
                      static_cast<unsigned long long>(schema), static_cast<unsigned long long>(known)));
    }

    void skip(std::size_t bytes)
    {
        for (std::size_t i = 0; i < bytes && !chunks_.payload().failed; i++)
            crn_wire_read(&chunks_.payload(), 1);
    }

    // A tool of protocol 5 has five values, its knots, three values of its balloon, the balloon's table, and
    // its layers. In protocol 6, two lengths lie before the layers.
    void take_tool(std::vector<std::uint8_t> &head)
    {
        crn_wire_reader &payload = chunks_.payload();
        const auto copy = [&](const auto &read) {
            const std::size_t begin = payload.position;
            read();
            if (payload.failed)
                chunks_.fail(RecordingFault::inconsistent, "is inconsistent: a tool is cut off");
            head.insert(head.end(), payload.bytes + begin, payload.bytes + payload.position);
        };
        const auto add_zeros = [&](std::size_t bytes) { head.insert(head.end(), bytes, 0); };
        copy([&] {
            get_text(payload);
            skip(8 + 5 * 4);
            skip(crn_wire_read(&payload, 2) * CRN_WIRE_BYTES_knot);
            skip(3 * 4);
            skip(crn_wire_read(&payload, 2) * CRN_WIRE_BYTES_balloon_point);
            if (is_protocol_6()) skip(length_bytes);
        });
        add_zeros(is_protocol_6() ? material_bytes : length_bytes + material_bytes);
        copy([&] {
            const std::size_t layers = crn_wire_read(&payload, 2);
            for (std::size_t i = 0; i < layers && !payload.failed; i++) {
                skip(8 + 8);
                get_text(payload);
                skip(8 + 8);
            }
        });
    }

    void take_chunk()
    {
        const std::uint32_t kind = chunks_.kind();
        if (kind == SNAPSHOT || kind == RESUMED) return take_snapshot();
        if (kind == TICKS && !has_order_lists()) return take_ticks();
        if (kind == VIEW) return take_view();
        add(kind, chunks_.payload_bytes());
    }

    // The upgraded snapshot states that no tool has a set, that the walls are at rest and, before protocol 6,
    // that no tool was released by a replacement, and which tools are in use. A snapshot of an unknown form
    // stays unchanged: a device refuses it, as before the conversion.
    void take_snapshot()
    {
        const auto old = chunks_.payload_bytes();
        const auto part = [&](std::size_t at) { return old.begin() + static_cast<std::ptrdiff_t>(at); };
        const std::uint32_t wanted =
            is_protocol_6() ? protocol_6_snapshot_version : protocol_5_snapshot_version;
        const std::size_t tools = 4 + snapshot_head_bytes,
                          words = tools + snapshot_tools * snapshot_tool_bytes;
        if (old.size() < words + node_bytes || old[4] != wanted) return add(chunks_.kind(), old);
        const std::size_t nodes = old.size() - node_bytes;
        std::vector<std::uint8_t> bytes(old.begin(), part(tools));
        bytes[4] = snapshot_version;
        if (is_protocol_6()) {
            bytes.insert(bytes.end(), part(tools), part(nodes));
        } else {
            for (std::size_t at = tools; at < words; at += snapshot_tool_bytes) {
                bytes.insert(bytes.end(), part(at), part(at + snapshot_tool_bytes));
                bytes.insert(bytes.end(), release_bytes, 0);
            }
            bytes.insert(bytes.end(), part(words), part(nodes));
            for (std::uint32_t i = 0; i < exchange_words; i++)
                put_word(bytes, i >= 1 && i <= positions_ ? i : 0);
        }
        bytes.insert(bytes.end(), set_bytes + wall_bytes, 0);
        bytes.insert(bytes.end(), part(nodes), old.end());
        add(chunks_.kind(), bytes);
    }

    void take_ticks()
    {
        const std::uint32_t first = chunks_.read_u32(), count = chunks_.read_u32();
        if (chunks_.payload().length != 8 + count * old_tick_bytes(positions_))
            chunks_.fail(RecordingFault::inconsistent, "is inconsistent: ticks are missing or doubled");
        std::vector<std::uint8_t> ticks(8 + count * tick_bytes_max(positions_));
        crn_wire_writer writer = crn_wire_writer_make(ticks.data(), ticks.size());
        crn_wire_write(&writer, first, 4);
        crn_wire_write(&writer, count, 4);
        for (std::uint32_t i = 0; i < count; i++) {
            const crn_wire_tick_input input = read_input();
            crn_wire_put_tick_input(&writer, &input);
            crn_wire_write(&writer, crn_wire_read(&chunks_.payload(), 8), 8); // both lanes
        }
        chunks_.check_used_up("ticks");
        ticks.resize(writer.length);
        add(TICKS, ticks);
    }

    std::uint8_t read_u8() { return static_cast<std::uint8_t>(crn_wire_read(&chunks_.payload(), 1)); }
    std::uint16_t read_u16() { return static_cast<std::uint16_t>(crn_wire_read(&chunks_.payload(), 2)); }

    crn_wire_tick_input read_input()
    {
        crn_wire_tick_input input{};
        input.hands_count = read_u16();
        if (input.hands_count != positions_)
            chunks_.fail(RecordingFault::inconsistent, "is inconsistent: another number of hands than tools");
        for (std::size_t k = 0; k < positions_; k++) {
            input.hands[k].translation_counts = chunks_.read_i32();
            input.hands[k].rotation_counts = chunks_.read_i32();
        }
        input.buttons = chunks_.read_u32();
        input.syringe_counts = chunks_.read_i32();
        input.inflator_raw = chunks_.read_i32();
        read_orders(input.orders);
        return input;
    }

    // In protocol 4, a tick without a command of some kind has zeros in all fields of that kind.
    void read_orders(crn_wire_order_list &orders)
    {
        const auto take = [&](bool is_there, const crn_wire_order &order) {
            if (is_there) orders.items[orders.items_count++] = order;
        };
        crn_wire_rhythm rhythm{};
        rhythm.action = read_u8();
        rhythm.value = read_u16();
        crn_wire_scaffold scaffold{};
        scaffold.lesion = read_u8();
        scaffold.first = read_u8();
        scaffold.last = read_u8();
        scaffold.open_q15 = read_u16();
        crn_wire_strut strut{};
        strut.number = read_u8();
        strut.joined = read_u8();
        strut.x_um = chunks_.read_i32();
        strut.y_um = chunks_.read_i32();
        strut.z_um = chunks_.read_i32();
        strut.inside_um = read_u16();
        strut.thickness_um = read_u16();
        take(rhythm.action != 0, crn_wire_order_of_rhythm(rhythm));
        take(scaffold.lesion != 0, crn_wire_order_of_scaffold(scaffold));
        take(strut.number != 0, crn_wire_order_of_strut(strut));
    }

    // Version 2 of the recording's format stored the whole view of the C-arm whenever a part of it changed.
    // The conversion makes commands only of those parts of the view that differ from the previous view.
    void take_view()
    {
        const std::uint32_t tick = chunks_.read_u32();
        std::array<std::int32_t, 8> view{};
        view[0] = read_u8() != 0;
        view[1] = read_u8() != 0;
        for (std::size_t i = 2; i < view.size(); i++) view[i] = chunks_.read_i32();
        chunks_.check_used_up("view");
        const auto is_new = [&](std::size_t from, std::size_t to) {
            return !last_view_ ||
                   !std::equal(view.begin() + from, view.begin() + to, last_view_->begin() + from);
        };
        if (is_new(2, 4)) add_command(tick, {RoomAction::angles, {view[2], view[3], 0}});
        if (is_new(7, 8)) add_command(tick, {RoomAction::field, {view[7], 0, 0}});
        if (is_new(1, 2) || is_new(4, 7)) {
            add_command(tick, {RoomAction::table, {view[4], view[5], view[6]}});
            add_command(tick, {RoomAction::follow, {view[1], 0, 0}});
        }
        if (is_new(0, 1)) add_command(tick, {RoomAction::fluoro_pedal, {view[0], 0, 0}});
        last_view_ = view;
    }

    void add_command(std::uint32_t tick, const RoomCommand &command)
    {
        add(ROOM, command_payload(tick, command));
    }

    ChunkReader chunks_;
    const VersionMark mark_;
    std::size_t positions_ = 0;
    std::optional<std::array<std::int32_t, 8>> last_view_; // fluoro, follow, angles, table, field
    std::vector<std::uint8_t> bytes_;
};

} // namespace

std::vector<std::uint8_t> upgraded_recording(std::span<const std::uint8_t> bytes, const std::string &name)
{
    std::vector<std::uint8_t> converted = Upgrade(bytes, name).run();
    parse_recording(converted, name); // an inconsistent chunk stays inconsistent, and is refused
    return converted;
}

Recording upgrade_recording(const std::string &path, const std::string &new_path)
{
    const std::vector<std::uint8_t> bytes = upgraded_recording(read_recording_bytes(path), path);
    write_whole_file(new_path, {reinterpret_cast<const char *>(bytes.data()), bytes.size()});
    return parse_recording(bytes, new_path);
}

} // namespace crn
