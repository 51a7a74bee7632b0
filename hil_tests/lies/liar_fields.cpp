// Falsifies one field of one message of a device.
#include "hil_tests/cases/conversation.hpp"
#include "hil_tests/lies/liar.hpp"
#include <algorithm>
#include <map>
#include <memory>

namespace hil
{

namespace
{

// Decodes the message in the frame, applies the function `change` to it, and encodes it again. If the message
// cannot be decoded, or no longer fits into its frame after the change, the frame stays unchanged.
template <class Message>
bool alter(Frame &frame, bool (*decode)(const std::uint8_t *, std::size_t, Message *),
           bool (*put)(crn_wire_writer *, const Message *), const std::function<void(Message &)> &change)
{
    const auto message = std::make_unique<Message>();
    if (!decode(frame.payload.data(), frame.payload.size(), message.get())) return false;
    change(*message);
    Bytes bytes(CRN_WIRE_PAYLOAD_MAX);
    crn_wire_writer writer = crn_wire_writer_make(bytes.data(), bytes.size());
    if (!put(&writer, message.get())) return false;
    bytes.resize(writer.length);
    frame.payload = bytes;
    return true;
}

#define ALTER(name, ...)                                                                                     \
    alter<crn_wire_##name>(frame, crn_wire_decode_##name,                                                    \
                           crn_wire_put_##name, [&]([[maybe_unused]] crn_wire_##name & m) __VA_ARGS__)

bool about_hello(const std::string &field, std::uint32_t value, Frame &frame)
{
    return ALTER(hello_reply, {
        if (field == "refused") m.accepted = 0;
        if (field == "schema") m.schema_hash ^= 1;
        if (field == "core") m.core_version = value == 1 ? m.core_version + 1 : value;
        if (field == "tick_us") m.tick_us = value;
        if (field == "capabilities") m.capabilities = value;
        if (field == "snapshot_bytes") m.snapshot_bytes = value;
        if (field == "serial" && value == 0) m.serial_count = 0;
        if (field == "serial" && value == 1) {
            m.serial_count = 6;
            const char escape[] = "\x1b[2J\n";
            std::copy_n(escape, 6, m.serial);
        }
    });
}

bool about_status(const std::string &field, std::uint32_t value, Frame &frame)
{
    return ALTER(status, {
        if (field == "state") m.state = static_cast<std::uint8_t>(value);
        if (field == "state" && value == 4) m.fault_code = 0xffff;
        if (field == "tick") m.tick = value;
        if (field == "arm_code") m.arm_code = value;
    });
}

bool about_set_up(const std::string &field, Frame &frame)
{
    const Bytes &scene = tube_scene();
    const auto bytes = static_cast<std::uint32_t>(scene.size());
    const std::uint32_t crc32 = crn_wire_crc32(0, scene.data(), scene.size());
    return ALTER(set_up, {
        if (field == "scene_is_there") m.scene_bytes = bytes, m.scene_crc32 = crc32;
        if (field == "scene_is_another") m.scene_bytes = bytes, m.scene_crc32 = ~crc32;
        if (field.rfind("upload", 0) == 0) m.upload_bytes = m.upload_received = bytes, m.upload_crc32 = crc32;
        if (field == "upload_is_beyond") m.upload_received = 0xffffff00;
    });
}

bool about_rig(const std::string &field, std::uint32_t value, Frame &frame)
{
    return ALTER(rig, {
        if (field == "tracks") m.tracks_count = 0;
        for (crn_wire_track &track : m.tracks) {
            if (field == "limits") track.force_limit_mN = track.torque_limit_uN_m = value;
            if (field == "scale") track.translation_pm_per_count = track.rotation_counts_per_turn = value;
        }
    });
}

bool about_ticks(const std::string &field, std::uint32_t value, Frame &frame, const Bytes &last_ticks)
{
    if (field == "repeated" && !last_ticks.empty()) {
        frame.payload = last_ticks;
        return true;
    }
    return ALTER(ticks, {
        if (field == "none") m.states_count = 0;
        if (field == "fewer" && m.states_count > 0) m.states_count--;
        if (m.states_count == 0) return;
        crn_wire_tick_state &state = m.states[m.states_count / 2];
        if (field == "lane0") state.hash_lane0 ^= 1;
        if (field == "lane1") state.hash_lane1 ^= 0x80000000u;
        if (field == "backwards") state.tick -= 2;
        if (field == "core_faults") state.core_fault_bits = value;
        for (crn_wire_tool_state &tool : state.tools) {
            if (field == "forces") tool.handle_axial_N_q22 = static_cast<std::int32_t>(value);
            if (field == "inserted") tool.inserted_m_q30 = static_cast<std::int32_t>(value);
        }
    });
}

bool about_hash(const std::string &field, std::uint32_t value, Frame &frame)
{
    return ALTER(hash64, {
        if (field == "value") m.hash ^= 1;
        if (field == "zero") m.hash = 0;
        if (field == "tick") m.tick = value == 0 || value == 0xffffffff ? value : m.tick + value;
    });
}

bool about_nodes(const std::string &field, std::uint32_t value, Frame &frame)
{
    const auto number = static_cast<std::int32_t>(value);
    return ALTER(nodes, {
        if (field == "count") m.positions_count = static_cast<std::uint16_t>(value);
        if (field == "tick") m.tick = value;
        if (field == "inserted") std::fill(std::begin(m.inserted_m_q30), std::end(m.inserted_m_q30), number);
        for (crn_wire_node_position &at : m.positions)
            if (field == "positions") at = {number, number, number};
    });
}

bool about_node_table(const std::string &field, std::uint32_t value, Frame &frame)
{
    return ALTER(node_table, {
        if (field == "count") m.arcs_m_q30_count = static_cast<std::uint16_t>(value);
        if (field == "arcs")
            std::fill(std::begin(m.arcs_m_q30), std::end(m.arcs_m_q30), static_cast<std::int32_t>(value));
    });
}

bool about_sensors(const std::string &field, std::uint32_t value, Frame &frame)
{
    const auto number = static_cast<std::int32_t>(value);
    return ALTER(sensors, {
        if (field == "tracks") m.tracks_count = 0;
        if (field == "absent") m.has_rig = 0;
        for (crn_wire_track_sensors &track : m.tracks) {
            if (field != "values") continue;
            track.translation_counts = track.rotation_counts = track.force_mN = track.motor_axial_mN = number;
            track.translation_sensor = track.over_current = 200;
        }
    });
}

bool about_faults(std::uint32_t value, Frame &frame)
{
    return ALTER(fault_log, {
        m.entries_count = CRN_WIRE_MAX_fault_log_entries;
        for (crn_wire_fault_entry &entry : m.entries) entry.code = static_cast<std::uint16_t>(value);
    });
}

bool about_live(const std::string &field, std::uint32_t value, Frame &frame)
{
    return ALTER(live, {
        if (field == "none") m.ticks_count = 0;
        const std::uint16_t count = m.ticks_count;
        for (std::uint16_t i = 0; i < count; i++) {
            if (field == "gap") m.ticks[i].state.tick += value;
            if (field == "backwards") m.ticks[i].state.tick -= std::min(m.ticks[i].state.tick, 20u);
            if (field == "hands") m.ticks[i].flags = 0;
        }
        if (count == 0) return;
        crn_wire_live_tick &tick = m.ticks[count / 2];
        if (field == "lane0") tick.state.hash_lane0 ^= 1;
        if (field == "input") tick.input.hands[0].translation_counts += static_cast<std::int32_t>(value);
        for (crn_wire_tool_state &tool : tick.state.tools)
            if (field == "states")
                tool.inserted_m_q30 = tool.handle_axial_N_q22 = static_cast<std::int32_t>(value);
    });
}

#undef ALTER

const std::map<std::string, std::uint16_t> types = {
    {"hello", CRN_WIRE_TYPE_hello_reply}, {"status", CRN_WIRE_TYPE_status},
    {"set_up", CRN_WIRE_TYPE_set_up},     {"rig", CRN_WIRE_TYPE_rig},
    {"ticks", CRN_WIRE_TYPE_ticks},       {"hash", CRN_WIRE_TYPE_hash64},
    {"final_hash", CRN_WIRE_TYPE_hash64}, {"snapshot", CRN_WIRE_TYPE_snapshot_begin},
    {"nodes", CRN_WIRE_TYPE_nodes},       {"node_table", CRN_WIRE_TYPE_node_table},
    {"sensors", CRN_WIRE_TYPE_sensors},   {"fault_log", CRN_WIRE_TYPE_fault_log},
    {"live", CRN_WIRE_TYPE_live},
};

template <class Message> Bytes nothing(bool (*put)(crn_wire_writer *, const Message *))
{
    const auto message = std::make_unique<Message>();
    Bytes bytes(CRN_WIRE_PAYLOAD_MAX);
    crn_wire_writer writer = crn_wire_writer_make(bytes.data(), bytes.size());
    put(&writer, message.get());
    bytes.resize(writer.length);
    return bytes;
}

} // namespace

std::uint16_t type_of(const Lie &lie)
{
    const auto found = types.find(lie.group());
    return found == types.end() ? std::uint16_t{0} : found->second;
}

Frame empty_message(std::uint16_t type)
{
    Frame frame{{1, 0, type}, {}};
    switch (type) {
#define NOTHING(name)                                                                                        \
    case CRN_WIRE_TYPE_##name:                                                                               \
        frame.payload = nothing<crn_wire_##name>(crn_wire_put_##name);                                       \
        break
        NOTHING(hello_reply);
        NOTHING(status);
        NOTHING(set_up);
        NOTHING(rig);
        NOTHING(ticks);
        NOTHING(hash64);
        NOTHING(snapshot_begin);
        NOTHING(nodes);
        NOTHING(node_table);
        NOTHING(sensors);
        NOTHING(fault_log);
        NOTHING(live);
        NOTHING(notice);
        NOTHING(reject);
#undef NOTHING
    default:
        break;
    }
    return frame;
}

bool change_field(const Lie &lie, Frame &frame, const Bytes &last_ticks)
{
    const std::string group = lie.group(), field = lie.word();
    if (group == "hello") return about_hello(field, lie.value, frame);
    if (group == "status") return about_status(field, lie.value, frame);
    if (group == "set_up") return about_set_up(field, frame);
    if (group == "rig") return about_rig(field, lie.value, frame);
    if (group == "ticks") return about_ticks(field, lie.value, frame, last_ticks);
    if (group == "hash" || group == "final_hash") return about_hash(field, lie.value, frame);
    if (group == "nodes") return about_nodes(field, lie.value, frame);
    if (group == "node_table") return about_node_table(field, lie.value, frame);
    if (group == "sensors") return about_sensors(field, lie.value, frame);
    if (group == "fault_log") return about_faults(lie.value, frame);
    if (group == "live") return about_live(field, lie.value, frame);
    return false;
}

} // namespace hil
