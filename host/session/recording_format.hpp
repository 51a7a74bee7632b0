// Defines the parts that recorder and reader have in common: the kinds of chunks, their sizes, and the
// encoding of the header.
#pragma once
#include "host/session/recording.hpp"
#include <bit>
#include <cstring>

namespace crn::recording_format
{

// The digit is the version. In versions 2 and 3 of the format, every tick had fields for all kinds of
// commands (orders), and version 2 had chunks of the kind VIEW instead of ROOM. In versions 2 to 4 of the
// format, all tools of a session were in use at once. In versions 2 to 5, every tool was elastic. The code in
// recording_upgrade.hpp converts files of these versions.
inline constexpr char magic[9] = "CRN-REC6";
inline constexpr char oldest_version = '2', protocol_5_version = '4', protocol_6_version = '5';

enum Kind : std::uint32_t {
    HEAD = 1,
    TICKS = 2,
    HASH = 3,
    SNAPSHOT = 4,
    VIEW = 5,
    END = 6,
    RESUMED = 7,
    ROOM = 8,
    SIDE_HOLES = 9,
    STENT = 10,
    BALLOON = 11
};

inline constexpr std::size_t chunk_head_bytes = 8, chunk_tail_bytes = 4;
inline constexpr std::size_t text_bytes_max = 4096;
inline constexpr std::size_t layers_max = 256;
inline constexpr std::uint32_t side_holes_max = 40; // groups, and holes of a group
inline constexpr std::size_t stent_bytes_max = 1024;
inline constexpr std::size_t recorded_stents_max = 64;
inline constexpr double side_holes_end_max_m = 2.0, side_hole_diameter_max_m = 0.01;
inline constexpr std::size_t head_bytes_max = 1 << 18;
// The next two functions return the number of bytes of one tick, which consists of the record `tick_input`
// with this number of hands and of two hash lanes. tick_bytes_max() assumes all commands (orders) that a tick
// may have, and tick_bytes_min() none.
constexpr std::size_t tick_bytes_max(std::size_t tool_count)
{
    return CRN_WIRE_BYTES_tick_input - (CRN_WIRE_TOOL_MAX - tool_count) * CRN_WIRE_BYTES_hand + 8;
}
constexpr std::size_t tick_bytes_min(std::size_t tool_count)
{
    return tick_bytes_max(tool_count) -
           static_cast<std::size_t>(CRN_WIRE_MAX_order_list_items) * CRN_WIRE_BYTES_order;
}
// Returns the number of bytes of one tick in protocol 4: hands, buttons, syringe, inflator, the fields of
// every kind of command, and the hash lanes.
constexpr std::size_t old_tick_bytes(std::size_t tool_count)
{
    return 2 + tool_count * 8 + 3 * 4 + 26 + 8;
}
inline constexpr std::uint64_t schema_of_protocol_4 = 0xfe912b8c91b717bb; // its last one
inline constexpr std::uint64_t schema_of_protocol_5 = 0x6cc533673f6eff5c;
inline constexpr std::uint64_t schema_of_protocol_6 = 0xd0825c0bc52def3a;
inline constexpr std::size_t view_bytes = 4 + 2 + 6 * 4; // of version 2
inline constexpr std::size_t command_bytes = 4 + 2 + 3 * 4;
inline constexpr std::size_t side_holes_bytes = 1 + 8 + 8 + 4 + 8;
inline constexpr std::size_t balloon_markers_max = 8;
constexpr std::size_t balloon_bytes(std::size_t markers)
{
    return 1 + 3 * 8 + 1 + markers * 8;
}
inline constexpr double balloon_max_kPa = 1e4, balloon_profile_max_m = 0.05, balloon_marker_max_m = 2.0;
inline constexpr std::size_t hash_bytes = 4 + 8; // HASH and END
inline constexpr std::size_t state_bytes_max = 4 + (1 << 20);

// Returns true if a chunk of this kind can have this number of bytes. An impossible length of a chunk means
// that the file was damaged, and not merely cut off.
constexpr bool is_size_of(std::uint32_t kind, std::size_t bytes, std::size_t tool_count)
{
    switch (kind) {
    case HEAD:
        return bytes <= head_bytes_max;
    case TICKS:
        return bytes >= 8 && bytes <= 8 + Recorder::ticks_per_chunk * tick_bytes_max(tool_count);
    case SNAPSHOT:
    case RESUMED:
        return bytes > 4 && bytes <= state_bytes_max;
    case ROOM:
        return bytes == command_bytes;
    case SIDE_HOLES:
        return bytes == side_holes_bytes;
    case STENT:
        return bytes <= stent_bytes_max;
    case BALLOON:
        return bytes >= balloon_bytes(0) && bytes <= balloon_bytes(balloon_markers_max);
    default:
        return bytes == hash_bytes;
    }
}

inline void put_text(crn_wire_writer &writer, const std::string &text)
{
    const std::size_t bytes = std::min(text.size(), text_bytes_max);
    crn_wire_write(&writer, bytes, 2);
    for (std::size_t i = 0; i < bytes; i++) crn_wire_write(&writer, static_cast<std::uint8_t>(text[i]), 1);
}

inline std::string get_text(crn_wire_reader &reader)
{
    const std::size_t bytes = crn_wire_read(&reader, 2);
    std::string text;
    if (bytes > text_bytes_max) reader.failed = true;
    for (std::size_t i = 0; i < bytes && !reader.failed; i++) {
        text.push_back(static_cast<char>(static_cast<unsigned char>(crn_wire_read(&reader, 1))));
    }
    return text;
}

inline std::vector<std::uint8_t> command_payload(std::uint32_t tick, const RoomCommand &command)
{
    std::vector<std::uint8_t> bytes(command_bytes);
    crn_wire_writer writer = crn_wire_writer_make(bytes.data(), bytes.size());
    crn_wire_write(&writer, tick, 4);
    crn_wire_write(&writer, static_cast<std::uint16_t>(command.action), 2);
    for (std::int32_t value : command.values) crn_wire_write(&writer, static_cast<std::uint32_t>(value), 4);
    return bytes;
}

inline void put_double(crn_wire_writer &writer, double value)
{
    crn_wire_write(&writer, std::bit_cast<std::uint64_t>(value), 8);
}

inline double get_double(crn_wire_reader &reader)
{
    return std::bit_cast<double>(crn_wire_read(&reader, 8));
}

} // namespace crn::recording_format
