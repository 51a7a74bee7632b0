#include "host/link/link.hpp"
#include "host/base/format.hpp"
#include "host/base/interrupt.hpp"
#include <algorithm>
#include <utility>

namespace crn
{

std::string describe(const crn_wire_reject &reject, const std::string &device)
{
    return formatted("%s refused %s: %s: %s [%lu, %lu]. Remedy: %s", device.c_str(),
                     crn_wire_message_name(reject.request_type), crn_wire_reject_name(reject.code),
                     crn_wire_reject_text(reject.code), static_cast<unsigned long>(reject.detail1),
                     static_cast<unsigned long>(reject.detail2), crn_wire_reject_remedy(reject.code));
}

Link::Link(Transport &transport, Patience::Span patience)
    : transport_(transport), patience_(patience), incoming_(1 << 16), outgoing_(CRN_WIRE_PAYLOAD_MAX),
      frame_(CRN_WIRE_FRAME_MAX)
{
    crn_wire_decoder_init(&decoder_);
}

// --- frames out (link_receive.cpp: frames in) ---

// The time that a device takes to accept the host's bytes counts towards the time limit, as does the time
// that it takes to answer.
void Link::write(std::span<const std::uint8_t> bytes)
{
    patience_.begin();
    transport_.write(bytes);
    patience_.end();
}

template <class Message, class Put>
void Link::send_message(std::uint16_t type, const Message &message, Put put, bool goes_on)
{
    crn_wire_writer writer = crn_wire_writer_make(outgoing_.data(), outgoing_.size());
    if (!put(&writer, &message)) {
        throw LinkError(
            formatted("%s does not fit a message: a list is too long", crn_wire_message_name(type)));
    }
    send(type, writer);
    if (!goes_on) asked_from_ = sequence_;
}

void Link::send(std::uint16_t type, const crn_wire_writer &payload)
{
    sequence_ = static_cast<std::uint16_t>(sequence_ == UINT16_MAX ? 1 : sequence_ + 1);
    const crn_wire_header header = {sequence_, 0, type};
    const std::size_t bytes =
        crn_wire_frame_encode(&header, payload.bytes, payload.length, frame_.data(), frame_.size());
    has_spoken_ = true;
    write({frame_.data(), bytes});
}

// --- handshake and set-up ---

// Returns true when answered. While the host waits for the answer to HELLO, every other frame that arrives,
// complete or cut, belongs to an earlier conversation.
bool Link::ask_hello(const crn_wire_hello &hello)
{
    const std::uint8_t end_of_frame = 0; // ends a frame that an earlier host, or a cut cable, left unfinished
    crn_wire_decoder_init(&decoder_);
    incoming_position_ = incoming_count_ = 0;
    bytes_without_frame_ = 0;
    live_tick_.reset();
    write({&end_of_frame, 1});
    send_message(CRN_WIRE_TYPE_hello, hello, crn_wire_put_hello);
    patience_.begin();
    waits_for_ = CRN_WIRE_TYPE_hello_reply;
    for (std::uint32_t frames = frames_at_once_max; receive_one_of(frames);) {
        if (decoder_.header.answers != sequence_) continue;
        file_frame();
        if (decoder_.header.type != CRN_WIRE_TYPE_hello_reply) continue;
        patience_.end();
        return true;
    }
    patience_.give_up();
    return false;
}

// The message HELLO starts the conversation of host and device anew, whatever bytes were lost or cut before.
// If the device restarted in the middle of a frame, its reply to HELLO follows an incomplete frame and is
// lost. If the reply to HELLO is lost, the host sends HELLO once more.
crn_wire_hello_reply Link::hello_once()
{
    const crn_wire_hello hello = {CRN_WIRE_PROTOCOL_MAJOR, CRN_WIRE_PROTOCOL_MINOR, crn_wire_schema_hash()};
    bool is_answered = ask_hello(hello);
    const std::uint32_t *counts = decoder_.event_counts;
    const bool is_torn = counts[CRN_WIRE_BAD_COBS] + counts[CRN_WIRE_BAD_SIZE] + counts[CRN_WIRE_BAD_CRC] +
                             counts[CRN_WIRE_BAD_LENGTH] >
                         0;
    if (!is_answered && is_torn) is_answered = ask_hello(hello);
    if (!is_answered) silent();
    if (!hello_reply_.accepted) {
        throw LinkError(formatted(
            "device and host speak different versions: device %u.%u schema %016llx, "
            "host %u.%u schema %016llx; install the same release on both",
            unsigned{hello_reply_.protocol_major}, unsigned{hello_reply_.protocol_minor},
            static_cast<unsigned long long>(hello_reply_.schema_hash), unsigned{hello.protocol_major},
            unsigned{hello.protocol_minor}, static_cast<unsigned long long>(hello.schema_hash)));
    }
    return hello_reply_;
}

// An interrupted upload of the same scene continues where it stopped. A scene that the device already has is
// not sent again.
void Link::load_scene(std::span<const std::uint8_t> scene)
{
    load_scene(scene, crn_wire_crc32(0, scene.data(), scene.size()));
}

void Link::load_scene(std::span<const std::uint8_t> scene, std::uint32_t crc32)
{
    if (scene.size() > UINT32_MAX) throw LinkError("the scene is larger than 4 GiB");
    const auto bytes = static_cast<std::uint32_t>(scene.size());
    const crn_wire_scene_begin begin = {bytes, crc32};
    const crn_wire_set_up there = read_set_up();
    if (bytes > 0 && there.scene_bytes == bytes && there.scene_crc32 == begin.crc32) return;
    const bool goes_on = there.upload_bytes == bytes && there.upload_crc32 == begin.crc32;
    send_message(CRN_WIRE_TYPE_scene_begin, begin, crn_wire_put_scene_begin);
    receive_answer(CRN_WIRE_TYPE_status);
    if (bytes == 0) return;
    crn_wire_scene_chunk chunk;
    for (std::uint32_t offset = goes_on ? there.upload_received : 0; offset < bytes;
         offset += chunk.data_count) {
        chunk.offset = offset;
        chunk.data_count =
            static_cast<std::uint16_t>(std::min<std::size_t>(sizeof chunk.data, bytes - offset));
        std::copy_n(scene.data() + offset, chunk.data_count, chunk.data);
        send_message(CRN_WIRE_TYPE_scene_chunk, chunk, crn_wire_put_scene_chunk, true);
        if (is_interrupted())
            throw LinkError("interrupted while the scene was sent; the next session continues the upload");
    }
    const crn_wire_scene_end end = {bytes};
    send_message(CRN_WIRE_TYPE_scene_end, end, crn_wire_put_scene_end, true);
    receive_answer(CRN_WIRE_TYPE_status);
}

void Link::load_tools(std::span<const crn_wire_instrument> tools, std::span<const std::uint8_t> line)
{
    crn_wire_tools message{};
    const std::size_t positions = line.empty() ? tools.size() : line.size();
    if (positions < 1 || positions > CRN_WIRE_TOOL_MAX)
        throw LinkError(formatted("a line holds 1 to %d tools, not %zu", int{CRN_WIRE_TOOL_MAX}, positions));
    if (tools.empty() || tools.size() > CRN_WIRE_TABLE_MAX)
        throw LinkError(
            formatted("a table holds 1 to %d tools, not %zu", int{CRN_WIRE_TABLE_MAX}, tools.size()));
    message.line_count = static_cast<std::uint16_t>(line.size());
    std::copy(line.begin(), line.end(), message.line);
    message.tools_count = static_cast<std::uint16_t>(tools.size());
    std::copy(tools.begin(), tools.end(), message.tools);
    send_message(CRN_WIRE_TYPE_tools, message, crn_wire_put_tools);
    receive_answer(CRN_WIRE_TYPE_status);
}

void Link::set_entry(const crn_wire_entry &entry)
{
    send_message(CRN_WIRE_TYPE_entry, entry, crn_wire_put_entry);
    receive_answer(CRN_WIRE_TYPE_status);
}

void Link::set_rig(const crn_wire_rig &rig)
{
    send_message(CRN_WIRE_TYPE_rig, rig, crn_wire_put_rig);
    receive_answer(CRN_WIRE_TYPE_status);
}

crn_wire_status Link::command(std::uint8_t action)
{
    const crn_wire_command command = {action, 0, 0};
    last_input_.reset();
    send_message(CRN_WIRE_TYPE_command, command, crn_wire_put_command);
    receive_answer(CRN_WIRE_TYPE_status);
    tick_ = status_.tick;
    return status_;
}

crn_wire_status Link::arm()
{
    const crn_wire_status status = command(CRN_WIRE_ACTION_ARM);
    ticks_given_ = live_ticks_.size(); // from an earlier session
    drop_given();
    get(CRN_WIRE_GET_NODE_TABLE, CRN_WIRE_TYPE_node_table);
    hash64_.reset();
    return status;
}

crn_wire_status Link::start()
{
    command(CRN_WIRE_ACTION_START);
    live_tick_ = tick_;
    return status_;
}

crn_wire_status Link::stop()
{
    return command(CRN_WIRE_ACTION_STOP);
}

crn_wire_status Link::reset()
{
    return command(CRN_WIRE_ACTION_RESET);
}

crn_wire_status Link::use_lockstep()
{
    return command(CRN_WIRE_ACTION_LOCKSTEP);
}

crn_wire_status Link::use_free_run()
{
    return command(CRN_WIRE_ACTION_FREE_RUN);
}

// Powering the motors takes two commands, so that no stray frame powers a motor: the second command, CONFIRM,
// must return the code that the device sent.
crn_wire_status Link::arm_motors()
{
    const crn_wire_status asked = command(CRN_WIRE_ACTION_ARM_MOTORS);
    const crn_wire_command confirm = {CRN_WIRE_ACTION_CONFIRM, asked.arm_code, 0};
    send_message(CRN_WIRE_TYPE_command, confirm, crn_wire_put_command);
    receive_answer(CRN_WIRE_TYPE_status);
    return status_;
}

crn_wire_status Link::stop_at(std::uint32_t tick)
{
    const crn_wire_command stop = {CRN_WIRE_ACTION_STOP, 0, tick};
    send_message(CRN_WIRE_TYPE_command, stop, crn_wire_put_command);
    receive_answer(CRN_WIRE_TYPE_status);
    return status_;
}

void Link::set_stream(const crn_wire_stream &stream)
{
    send_message(CRN_WIRE_TYPE_stream, stream, crn_wire_put_stream);
    receive_answer(CRN_WIRE_TYPE_status);
}

// --- ticks ---

std::span<const crn_wire_tick_state> Link::step(std::span<const crn_wire_tick_input> inputs, bool want_nodes)
{
    if (inputs.empty() || inputs.size() > steps_max) {
        throw LinkError(formatted("a step takes 1 .. %zu inputs, not %zu", steps_max, inputs.size()));
    }
    crn_wire_step step;
    step.tick = tick_;
    step.want_nodes = want_nodes;
    step.inputs_count = static_cast<std::uint16_t>(inputs.size());
    std::copy(inputs.begin(), inputs.end(), step.inputs);
    send_message(CRN_WIRE_TYPE_step, step, crn_wire_put_step);
    receive_answer(CRN_WIRE_TYPE_ticks, inputs.size());
    if (ticks_.states_count > inputs.size()) broken("ticks");
    for (std::uint16_t i = 0; i < ticks_.states_count; i++) {
        if (ticks_.states[i].tick != tick_ + i + 1) broken("ticks");
    }
    tick_ += ticks_.states_count;
    if (ticks_.states_count != inputs.size()) {
        const std::uint16_t code = read_status().fault_code;
        throw LinkError(formatted("device fault at tick %lu: %s: %s. Remedy: %s",
                                  static_cast<unsigned long>(tick_), crn_wire_fault_name(code),
                                  crn_wire_fault_text(code), crn_wire_fault_remedy(code)));
    }
    return {ticks_.states, ticks_.states_count};
}

void Link::send_input(const crn_wire_tick_input &input)
{
    const crn_wire_input message = {input};
    send_message(CRN_WIRE_TYPE_input, message, crn_wire_put_input);
    last_input_ = input;
}

void Link::give_orders(const crn_wire_order_list &orders)
{
    const crn_wire_orders message = {orders};
    send_message(CRN_WIRE_TYPE_orders, message, crn_wire_put_orders);
    receive_answer(CRN_WIRE_TYPE_status);
}

// Sends a heartbeat, unless the host has sent something since the last call. The device's reply to a
// heartbeat is stored with other frames for which no caller waits.
void Link::beat()
{
    const crn_wire_get request = {CRN_WIRE_GET_STATUS};
    if (has_spoken_) {
        has_spoken_ = false;
        return;
    }
    if (last_input_) {
        send_input(*last_input_);
    } else {
        send_message(CRN_WIRE_TYPE_get, request, crn_wire_put_get);
    }
    has_spoken_ = false;
}

void Link::say_present()
{
    has_spoken_ = false;
    beat();
}

// Removes from the list of received ticks those that the last call returned to the caller. Ticks that arrived
// since the last call, together with replies to other requests, stay in the list.
void Link::drop_given()
{
    const auto given = static_cast<std::ptrdiff_t>(ticks_given_);
    free_run_states_.erase(free_run_states_.begin(), free_run_states_.begin() + given);
    live_ticks_.erase(live_ticks_.begin(), live_ticks_.begin() + given);
    ticks_given_ = 0;
}

void Link::take_what_came(std::uint32_t &frames)
{
    patience_.begin();
    waits_for_ = 0;
    while (receive_one_of(frames)) file_frame();
    patience_.end();
}

std::vector<crn_wire_tick_state> Link::free_run(std::uint32_t milliseconds)
{
    drop_given();
    std::uint32_t frames = frames_at_once_max;
    try {
        for (std::uint32_t left = milliseconds; left > 0;) {
            const std::uint32_t slice = std::min(left, heartbeat_ms);
            beat();
            transport_.pass_time_ms(slice);
            take_what_came(frames);
            frames = frames_at_once_max;
            left -= slice;
        }
        if (milliseconds == 0) transport_.pass_time_ms(0);
        take_what_came(frames);
    } catch (...) {
        ticks_given_ = live_ticks_.size();
        throw;
    }
    ticks_given_ = live_ticks_.size();
    return free_run_states_;
}

// --- reading ---

void Link::get(std::uint8_t what, std::uint16_t answer)
{
    const crn_wire_get request = {what};
    send_message(CRN_WIRE_TYPE_get, request, crn_wire_put_get);
    receive_answer(answer);
}

const crn_wire_nodes &Link::read_nodes()
{
    get(CRN_WIRE_GET_NODES, CRN_WIRE_TYPE_nodes);
    return nodes_;
}

const crn_wire_contacts &Link::read_contacts()
{
    get(CRN_WIRE_GET_CONTACTS, CRN_WIRE_TYPE_contacts);
    return contacts_;
}

Hash64 Link::read_hash64()
{
    get(CRN_WIRE_GET_HASH64, CRN_WIRE_TYPE_hash64);
    return received_hash64_;
}

crn_wire_status Link::read_status()
{
    get(CRN_WIRE_GET_STATUS, CRN_WIRE_TYPE_status);
    return status_;
}

crn_wire_fault_log Link::read_fault_log()
{
    get(CRN_WIRE_GET_FAULT_LOG, CRN_WIRE_TYPE_fault_log);
    return fault_log_;
}

crn_wire_rig Link::read_rig()
{
    get(CRN_WIRE_GET_RIG, CRN_WIRE_TYPE_rig);
    return rig_;
}

crn_wire_set_up Link::read_set_up()
{
    get(CRN_WIRE_GET_SET_UP, CRN_WIRE_TYPE_set_up);
    return set_up_;
}

crn_wire_sensors Link::read_sensors()
{
    get(CRN_WIRE_GET_SENSORS, CRN_WIRE_TYPE_sensors);
    return sensors_;
}

std::vector<crn_wire_notice> Link::take_notices()
{
    return std::exchange(notices_, {});
}

std::vector<std::uint8_t> Link::read_snapshot()
{
    get(CRN_WIRE_GET_SNAPSHOT, CRN_WIRE_TYPE_snapshot_end);
    return snapshot_;
}

void Link::write_snapshot(std::span<const std::uint8_t> snapshot)
{
    crn_wire_reader reader = crn_wire_reader_make(snapshot.data(), snapshot.size());
    crn_wire_read(&reader, 4);
    const auto tick = static_cast<std::uint32_t>(crn_wire_read(&reader, 4));
    const auto bytes = static_cast<std::uint32_t>(snapshot.size());
    const crn_wire_snapshot_begin begin = {tick, bytes, crn_wire_crc32(0, snapshot.data(), snapshot.size())};
    send_message(CRN_WIRE_TYPE_snapshot_begin, begin, crn_wire_put_snapshot_begin);
    receive_answer(CRN_WIRE_TYPE_status);
    crn_wire_snapshot_chunk chunk;
    for (std::uint32_t offset = 0; offset < bytes; offset += chunk.data_count) {
        chunk.offset = offset;
        chunk.data_count =
            static_cast<std::uint16_t>(std::min<std::size_t>(sizeof chunk.data, bytes - offset));
        std::copy_n(snapshot.data() + offset, chunk.data_count, chunk.data);
        send_message(CRN_WIRE_TYPE_snapshot_chunk, chunk, crn_wire_put_snapshot_chunk, true);
    }
    const crn_wire_snapshot_end end = {bytes};
    send_message(CRN_WIRE_TYPE_snapshot_end, end, crn_wire_put_snapshot_end, true);
    receive_answer(CRN_WIRE_TYPE_status);
    tick_ = status_.tick;
}

} // namespace crn
