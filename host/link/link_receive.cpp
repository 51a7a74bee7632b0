// Finds the frames in the bytes from the device, stores the frames by their type, and throws an exception for
// each refusal. The host cannot wait here for ever, because three quantities have limits: the bytes without a
// frame, the frames without an answer, and the time.
#include "host/base/format.hpp"
#include "host/base/interrupt.hpp"
#include "host/link/link.hpp"
#include <algorithm>

namespace crn
{

void Link::broken(const char *what) const
{
    throw LinkError(transport_.name() + " sent a " + what +
                    " message that does not have its form; use the same version on both sides");
}

void Link::silent() const
{
    const std::string wait = " (waiting for " + std::string(crn_wire_message_name(waits_for_)) + ")";
    if (is_interrupted()) throw LinkError(transport_.name() + " did not answer before Ctrl-C" + wait);
    throw LinkError(transport_.name() + " does not answer" + wait + "; check cable, power and port");
}

// Throws an error if a device is silent or slow, or if it sends other frames but not the answer.
void Link::check_patience()
{
    if (!transport_.has_own_clock() || !patience_.is_over()) return;
    patience_.give_up();
    if (is_interrupted()) silent();
    throw LinkError(
        transport_.name() +
        formatted(" kept the host waiting for %.1f s%s%s; take it off the bus, and use another firmware",
                  static_cast<double>(patience_.spent().count()) * 1e-3,
                  waits_for_ != 0 ? ", at last for " : "",
                  waits_for_ != 0 ? crn_wire_message_name(waits_for_) : ""));
}

// A device that sends without end causes an error in the same way as a silent device does. `frames` is the
// number of frames that may still arrive; no correct device sends so many without a pause.
bool Link::receive_one_of(std::uint32_t &frames)
{
    if (!receive()) return false;
    if (frames-- > 0) return true;
    throw LinkError(transport_.name() +
                    " talks without end and does not answer; take it off the bus, and use another firmware");
}

bool Link::receive()
{
    for (;;) {
        while (incoming_position_ < incoming_count_) {
            std::size_t taken = 0;
            const crn_wire_event event =
                crn_wire_decoder_take(&decoder_, incoming_.data() + incoming_position_,
                                      incoming_count_ - incoming_position_, &taken);
            incoming_position_ += taken;
            if (event != CRN_WIRE_FRAME) continue;
            bytes_without_frame_ = 0;
            return true;
        }
        check_patience();
        incoming_position_ = 0;
        incoming_count_ = transport_.read(incoming_);
        if (incoming_count_ == 0) return false;
        check_patience(); // the frame may be the answer, but too late for this device's budget
        bytes_without_frame_ += incoming_count_;
        if (bytes_without_frame_ <= bytes_without_frame_max) continue;
        bytes_without_frame_ = 0;
        incoming_count_ = 0;
        throw LinkError(
            transport_.name() +
            formatted(" sends bytes that are no message: %zu of them without a whole frame. Remedy: plug "
                      "it out and in; install this release's firmware, or unplug what uses the rig's number",
                      bytes_without_frame_max));
    }
}

// Stores the contents of a received frame. If the device refuses a request, the call that is waiting for the
// answer to this request throws an error.
void Link::file_frame()
{
    const std::uint8_t *payload = decoder_.payload;
    const std::size_t length = decoder_.payload_bytes;
    switch (decoder_.header.type) {
    case CRN_WIRE_TYPE_hello_reply:
        if (!crn_wire_decode_hello_reply(payload, length, &hello_reply_)) broken("hello_reply");
        break;
    case CRN_WIRE_TYPE_status:
        if (!crn_wire_decode_status(payload, length, &status_)) broken("status");
        break;
    case CRN_WIRE_TYPE_ticks:
        if (!crn_wire_decode_ticks(payload, length, &ticks_)) broken("ticks");
        break;
    case CRN_WIRE_TYPE_rig:
        if (!crn_wire_decode_rig(payload, length, &rig_)) broken("rig");
        break;
    case CRN_WIRE_TYPE_set_up:
        if (!crn_wire_decode_set_up(payload, length, &set_up_)) broken("set_up");
        break;
    case CRN_WIRE_TYPE_sensors:
        if (!crn_wire_decode_sensors(payload, length, &sensors_)) broken("sensors");
        break;
    case CRN_WIRE_TYPE_nodes:
        if (!crn_wire_decode_nodes(payload, length, &nodes_)) broken("nodes");
        break;
    case CRN_WIRE_TYPE_node_table:
        if (!crn_wire_decode_node_table(payload, length, &node_table_)) broken("node_table");
        break;
    case CRN_WIRE_TYPE_contacts:
        if (!crn_wire_decode_contacts(payload, length, &contacts_)) broken("contacts");
        break;
    case CRN_WIRE_TYPE_fault_log:
        if (!crn_wire_decode_fault_log(payload, length, &fault_log_)) broken("fault_log");
        break;
    case CRN_WIRE_TYPE_hash64: {
        crn_wire_hash64 hash;
        if (!crn_wire_decode_hash64(payload, length, &hash)) broken("hash64");
        received_hash64_ = {hash.tick, hash.hash};
        if (hash.tick % hash64_every_ticks == 0)
            hash64_ = received_hash64_;
        else if (waits_for_ != CRN_WIRE_TYPE_hash64)
            throw LinkError(transport_.name() +
                            formatted(" sent the hash of tick %u without a request; devices do so every %u "
                                      "ticks only. Remedy: install this release's firmware",
                                      unsigned{hash.tick}, unsigned{hash64_every_ticks}));
        break;
    }
    case CRN_WIRE_TYPE_reject: {
        crn_wire_reject reject;
        if (!crn_wire_decode_reject(payload, length, &reject)) broken("reject");
        throw LinkError(describe(reject, transport_.name()), reject);
    }
    default:
        file_stream();
    }
}

// Stores a batch of consecutive ticks that the device sent. A batch of ticks that arrives again is ignored,
// and the ticks of a missing batch are counted.
void Link::file_live()
{
    crn_wire_live live;
    if (!crn_wire_decode_live(decoder_.payload, decoder_.payload_bytes, &live)) broken("live");
    for (std::uint16_t i = 1; i < live.ticks_count; i++) {
        if (live.ticks[i].state.tick != live.ticks[0].state.tick + i) broken("live");
    }
    live_ = live;
    for (std::uint16_t i = 0; i < live.ticks_count; i++) {
        const std::uint32_t tick = live.ticks[i].state.tick;
        if (live_tick_ && tick <= *live_tick_) continue;
        if (live_tick_) ticks_missing_ += tick - *live_tick_ - 1;
        live_tick_ = tick;
        tick_ = std::max(tick_, tick);
        if (live_ticks_.size() == live_ticks_max) { // nothing reads them
            ticks_missing_++;
            continue;
        }
        live_ticks_.push_back(live.ticks[i]);
        free_run_states_.push_back(live.ticks[i].state);
    }
}

// Stores messages that a device sends without a request, or that consist of several frames.
void Link::file_stream()
{
    const std::uint8_t *payload = decoder_.payload;
    const std::size_t length = decoder_.payload_bytes;
    switch (decoder_.header.type) {
    case CRN_WIRE_TYPE_live:
        file_live();
        break;
    case CRN_WIRE_TYPE_notice: {
        crn_wire_notice notice;
        if (!crn_wire_decode_notice(payload, length, &notice)) broken("notice");
        if (notices_.size() == notices_max) notices_.erase(notices_.begin());
        notices_.push_back(notice);
        break;
    }
    case CRN_WIRE_TYPE_snapshot_begin:
        if (!crn_wire_decode_snapshot_begin(payload, length, &snapshot_begin_) ||
            snapshot_begin_.snapshot_bytes > snapshot_bytes_max) {
            snapshot_begin_ = {};
            broken("snapshot_begin");
        }
        snapshot_.clear();
        break;
    case CRN_WIRE_TYPE_snapshot_chunk: {
        crn_wire_snapshot_chunk chunk;
        if (!crn_wire_decode_snapshot_chunk(payload, length, &chunk) || chunk.offset != snapshot_.size() ||
            chunk.data_count > snapshot_begin_.snapshot_bytes - snapshot_.size()) {
            broken("snapshot_chunk");
        }
        snapshot_.insert(snapshot_.end(), chunk.data, chunk.data + chunk.data_count);
        break;
    }
    case CRN_WIRE_TYPE_snapshot_end:
        if (snapshot_.size() != snapshot_begin_.snapshot_bytes ||
            crn_wire_crc32(0, snapshot_.data(), snapshot_.size()) != snapshot_begin_.crc32) {
            broken("snapshot_end");
        }
        break;
    default:
        throw LinkError(transport_.name() +
                        formatted(" sent a message of unknown type %u; use the same version on both sides",
                                  static_cast<unsigned>(decoder_.header.type)));
    }
}

// Returns true if a refusal belongs to an earlier request whose time limit had expired, or to a command that
// the device did not receive completely.
bool Link::is_late_refusal() const
{
    if (decoder_.header.type != CRN_WIRE_TYPE_reject) return false;
    const auto since = static_cast<std::uint16_t>(decoder_.header.answers - asked_from_);
    const auto asked = static_cast<std::uint16_t>(sequence_ - asked_from_);
    return decoder_.header.answers == 0 || since > asked;
}

void Link::receive_answer(std::uint16_t type, std::size_t ticks)
{
    patience_.begin(Patience::free_per_tick * ticks);
    waits_for_ = type;
    for (std::uint32_t frames = frames_at_once_max;;) {
        if (!receive_one_of(frames)) {
            patience_.give_up();
            silent();
        }
        if (is_late_refusal()) continue;
        file_frame();
        if (decoder_.header.type != type || decoder_.header.answers != sequence_) continue;
        patience_.end();
        return;
    }
}

} // namespace crn
