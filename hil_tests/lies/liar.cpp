#include "hil_tests/lies/liar.hpp"
#include "hil_tests/campaign/faulty_pipe.hpp"
#include <algorithm>
#include <utility>

namespace hil
{

namespace
{

constexpr auto drip_every = std::chrono::milliseconds(20);

std::unique_ptr<crn_wire_decoder> new_decoder()
{
    auto decoder = std::make_unique<crn_wire_decoder>();
    crn_wire_decoder_init(decoder.get());
    return decoder;
}

Frame notice_frame()
{
    return {{1, 0, CRN_WIRE_TYPE_notice}, empty_message(CRN_WIRE_TYPE_notice).payload};
}

// If a lie replaces a whole message, the code of the fault campaign makes the false message.
std::uint32_t campaign_lie(const Lie &lie)
{
    static const char *const words[] = {"half",     "longer", "type",  "",      "ones",
                                        "negative", "large",  "count", "random"};
    for (std::uint32_t i = 0; i < std::size(words); i++)
        if (lie.word() == words[i]) return i;
    return 8;
}

} // namespace

Bytes encode(const Frame &frame)
{
    Bytes bytes(CRN_WIRE_FRAME_MAX);
    bytes.resize(crn_wire_frame_encode(&frame.header, frame.payload.data(), frame.payload.size(),
                                       bytes.data(), bytes.size()));
    return bytes;
}

Liar::Liar(const Lie &lie, unsigned frames, crn_sim *sim, std::function<void()> struck)
    : lie_(lie), place_(1 + (lie.at - 1) % std::max(frames, 1u)), sim_(sim), struck_(std::move(struck)),
      from_device_(new_decoder()), from_host_(new_decoder())
{
}

bool Liar::is_only_slow() const
{
    return lie_.is("stream.late_ms") || lie_.is("stream.drip_frames");
}

void Liar::strike()
{
    if (!has_struck_) struck_();
    has_struck_ = true;
}

void Liar::take(std::span<const std::uint8_t> bytes)
{
    for (const std::uint8_t byte : bytes)
        if (crn_wire_decoder_push(from_host_.get(), byte) == CRN_WIRE_FRAME) asked_ = from_host_->header;
    crn_sim_write(sim_, bytes.data(), bytes.size());
}

void Liar::say(const Bytes &bytes)
{
    if (lie_.is("stream.late_ms") && is_streaming_)
        late_.emplace_back(Clock::now() + std::chrono::milliseconds(lie_.value), bytes);
    else
        out_.insert(out_.end(), bytes.begin(), bytes.end());
}

// Reads the device's messages, frame by frame.
void Liar::pull()
{
    std::uint8_t bytes[4096];
    for (std::size_t count = crn_sim_read(sim_, bytes, sizeof bytes); count > 0;
         count = crn_sim_read(sim_, bytes, sizeof bytes)) {
        for (std::size_t i = 0; i < count; i++) {
            partial_.push_back(bytes[i]);
            const bool is_frame = crn_wire_decoder_push(from_device_.get(), bytes[i]) == CRN_WIRE_FRAME;
            if (bytes[i] != 0) continue;
            const Bytes raw = std::exchange(partial_, {});
            if (!is_frame) continue;
            pass({from_device_->header,
                  Bytes(from_device_->payload, from_device_->payload + from_device_->payload_bytes)},
                 raw);
        }
    }
}

void Liar::pass(Frame frame, const Bytes &raw)
{
    frames_++;
    if (is_streaming_ && !is_only_slow()) return;
    if (lie_about_snapshot(frame, raw) || lie_about_frame(frame, raw)) return;
    const bool is_changed = lie_about_message(frame);
    if (frame.header.type == CRN_WIRE_TYPE_ticks) last_ticks_ = frame.payload;
    say(is_changed ? encode(frame) : raw);
    if (!held_.empty()) say(std::exchange(held_, {}));
    if (frames_ == 2 && type_of(lie_) != 0 && seen_ == 0) forge();
}

// --- frames ---

bool Liar::lie_about_frame(const Frame &frame, const Bytes &raw)
{
    if (frames_ != place_) return false;
    if (lie_.is_group("stream.")) {
        same_ = raw;
        is_streaming_ = true;
        strike();
        if (lie_.is("stream.late_ms") || lie_.is("stream.drip_frames")) say(raw);
        return true;
    }
    if (lie_.is_group("message.")) {
        strike();
        say(lie_of(raw, campaign_lie(lie_), place_));
        return true;
    }
    if (!lie_.is_group("frame.")) return false;
    strike();
    Frame other = frame;
    if (lie_.is("frame.flip")) {
        Bytes bytes = raw;
        bytes[bytes.size() / 2] ^= 4;
        say(bytes);
    } else if (lie_.is("frame.twice")) {
        say(raw);
        say(raw);
    } else if (lie_.is("frame.swapped")) {
        held_ = raw;
    } else if (lie_.is("frame.cut")) {
        say(Bytes(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(raw.size() / 2)));
    } else if (lie_.is("frame.too_long")) {
        say(Bytes(100000, 0xff));
        say(raw);
    } else if (lie_.is("frame.answers")) {
        other.header.answers = static_cast<std::uint16_t>(other.header.answers + lie_.value);
        say(encode(other));
    } else if (lie_.is("frame.sequence")) {
        other.header.sequence = static_cast<std::uint16_t>(other.header.sequence - 1);
        say(encode(other));
    } else if (lie_.is("frame.refused")) {
        other = empty_message(CRN_WIRE_TYPE_reject);
        other.header.answers = frame.header.answers;
        other.payload[2] = static_cast<std::uint8_t>(lie_.value);
        other.payload[3] = static_cast<std::uint8_t>(lie_.value >> 8);
        say(encode(other));
    } // lost: nothing
    return true;
}

// --- messages ---

// A snapshot consists of a begin message, chunks and an end message. If a chunk in the middle is changed, the
// begin message must get the new checksum.
bool Liar::lie_about_snapshot(const Frame &frame, const Bytes &raw)
{
    if (!lie_.is_group("snapshot.")) return false;
    const std::uint16_t type = frame.header.type;
    const bool is_part = type == CRN_WIRE_TYPE_snapshot_begin || type == CRN_WIRE_TYPE_snapshot_chunk ||
                         type == CRN_WIRE_TYPE_snapshot_end;
    if (!is_part) return false;
    static_cast<void>(raw);
    snapshot_.push_back(frame);
    if (type != CRN_WIRE_TYPE_snapshot_end) return true;
    seen_++;
    strike();
    constexpr std::size_t chunk_head = 6; // offset u32, count u16
    Bytes whole;
    for (const Frame &part : snapshot_)
        if (part.header.type == CRN_WIRE_TYPE_snapshot_chunk)
            whole.insert(whole.end(), part.payload.begin() + chunk_head, part.payload.end());
    const auto alter = [&](std::size_t at, std::uint8_t by) { whole[at % whole.size()] ^= by; };
    if (lie_.is("snapshot.core") || lie_.is("snapshot.head")) alter(lie_.value, 1);
    if (lie_.is("snapshot.tick")) alter(4, static_cast<std::uint8_t>(lie_.value));
    if (lie_.is("snapshot.short")) whole.resize(whole.size() / 2);
    if (lie_.is("snapshot.empty")) whole.clear();
    crn_wire_snapshot_begin begin;
    crn_wire_decode_snapshot_begin(snapshot_[0].payload.data(), snapshot_[0].payload.size(), &begin);
    if (lie_.is("snapshot.begin_tick")) begin.tick += 100;
    begin.snapshot_bytes = static_cast<std::uint32_t>(whole.size());
    begin.crc32 = crn_wire_crc32(0, whole.data(), whole.size());
    crn_wire_writer writer = crn_wire_writer_make(snapshot_[0].payload.data(), snapshot_[0].payload.size());
    crn_wire_put_snapshot_begin(&writer, &begin);
    std::size_t given = 0;
    for (Frame &part : snapshot_) {
        if (part.header.type == CRN_WIRE_TYPE_snapshot_chunk) {
            const std::size_t count = std::min(part.payload.size() - chunk_head, whole.size() - given);
            if (count == 0) continue;
            part.payload.resize(chunk_head + count);
            part.payload[4] = static_cast<std::uint8_t>(count);
            part.payload[5] = static_cast<std::uint8_t>(count >> 8);
            std::copy_n(whole.begin() + static_cast<std::ptrdiff_t>(given), count,
                        part.payload.begin() + chunk_head);
            given += count;
        }
        if (part.header.type == CRN_WIRE_TYPE_snapshot_end)
            for (unsigned i = 0; i < 4; i++)
                part.payload[i] = static_cast<std::uint8_t>(whole.size() >> 8 * i);
        say(encode(part));
    }
    snapshot_.clear();
    return true;
}

bool Liar::lie_about_message(Frame &frame)
{
    if (type_of(lie_) != frame.header.type) return false;
    const bool is_final = asked_.type == CRN_WIRE_TYPE_get;
    if (lie_.is_group("final_hash.") != is_final && frame.header.type == CRN_WIRE_TYPE_hash64) return false;
    if (++seen_ != lie_.at) return false;
    strike();
    if (lie_.is("hash.twice_with_another_tick")) {
        Frame other = frame;
        other.payload[0]++;
        say(encode(other));
        return false;
    }
    return change_field(lie_, frame, last_ticks_);
}

// Sends a message that the host did not request; half of the lies mark this message as the answer to the
// host's present request.
void Liar::forge()
{
    Frame frame = empty_message(type_of(lie_));
    if (frame.payload.empty()) return;
    frame.header.sequence = 1;
    change_field(lie_, frame, last_ticks_);
    frame.header.answers = lie_.at % 2 == 0 ? asked_.sequence : 0;
    say(encode(frame));
}

// --- for ever ---

std::size_t Liar::drip(std::span<std::uint8_t> bytes)
{
    if (Clock::now() < next_drip_ || bytes.empty()) return 0;
    next_drip_ = Clock::now() + drip_every;
    if (lie_.is("stream.drip_frames")) {
        if (out_.empty()) return 0;
        bytes[0] = out_.front();
        out_.pop_front();
        return 1;
    }
    random_ = random_ * 1664525u + 1013904223u;
    bytes[0] = lie_.is("stream.drip_zeros") ? 0 : static_cast<std::uint8_t>(random_ >> 24);
    return 1;
}

std::size_t Liar::stream(std::span<std::uint8_t> bytes)
{
    if (lie_.is_group("stream.drip_")) return drip(bytes);
    if (lie_.is("stream.silence")) return 0;
    const auto fill = [&](const auto &next) {
        for (std::uint8_t &byte : bytes) byte = next();
        return bytes.size();
    };
    if (lie_.is("stream.zeros")) return fill([] { return std::uint8_t{0}; });
    if (lie_.is("stream.ones")) return fill([] { return std::uint8_t{0xff}; });
    if (lie_.is("stream.garbage")) {
        return fill([&] {
            random_ = random_ * 1664525u + 1013904223u;
            return static_cast<std::uint8_t>(random_ >> 24);
        });
    }
    Bytes frame = same_;
    if (lie_.is("stream.half_frames")) frame.resize(frame.size() / 2);
    if (lie_.is("stream.notices")) frame = encode(notice_frame());
    if (lie_.is("stream.live")) frame = encode(empty_message(CRN_WIRE_TYPE_live));
    if (lie_.is("stream.refusals")) frame = encode(empty_message(CRN_WIRE_TYPE_reject));
    while (flood_.size() < bytes.size()) flood_.insert(flood_.end(), frame.begin(), frame.end());
    return fill([&] {
        const std::uint8_t byte = flood_.front();
        flood_.pop_front();
        return byte;
    });
}

std::size_t Liar::give(std::span<std::uint8_t> bytes)
{
    pull();
    // The messages that the device sent before the false message still reach the host complete.
    if (is_streaming_ && out_.empty() && !is_only_slow()) return stream(bytes);
    if (is_streaming_ && lie_.is("stream.drip_frames")) return drip(bytes);
    while (!late_.empty() && late_.front().first <= Clock::now()) {
        out_.insert(out_.end(), late_.front().second.begin(), late_.front().second.end());
        late_.pop_front();
    }
    const std::size_t count = std::min(bytes.size(), out_.size());
    std::copy_n(out_.begin(), count, bytes.begin());
    out_.erase(out_.begin(), out_.begin() + static_cast<std::ptrdiff_t>(count));
    return count;
}

} // namespace hil
