#include "hil_tests/campaign/faulty_pipe.hpp"
#include "hil_tests/cases/conversation.hpp"
#include "hil_tests/plant/random.hpp"
#include "host/link/link.hpp"
#include "shared/wire/wire_frame.h"
#include <algorithm>
#include <memory>
#include <utility>

namespace hil
{

namespace
{

[[noreturn]] void gone()
{
    throw crn::LinkError("the device is gone: its cable was cut. Remedy: plug it in, then begin with HELLO");
}

// Changes the device's message so that the device claims to have a scene already. The device claims either
// that it has the host's whole scene, or that it has another scene of the same size, or that the upload of
// the host's scene is complete.
void claim_scene(std::uint32_t lie, std::vector<std::uint8_t> &payload)
{
    crn_wire_set_up there;
    if (!crn_wire_decode_set_up(payload.data(), payload.size(), &there)) return;
    const std::vector<std::uint8_t> &scene = tube_scene();
    const auto bytes = static_cast<std::uint32_t>(scene.size());
    const std::uint32_t crc32 = crn_wire_crc32(0, scene.data(), scene.size());
    if (lie == lie_upload_is_there) {
        there.upload_bytes = there.upload_received = bytes;
        there.upload_crc32 = crc32;
    } else {
        there.scene_bytes = bytes;
        there.scene_crc32 = lie == lie_scene_is_there ? crc32 : ~crc32;
    }
    crn_wire_writer writer = crn_wire_writer_make(payload.data(), payload.size());
    crn_wire_put_set_up(&writer, &there);
}

// Falsifies one property of a message: its length, its type, the request that it answers, or some bytes of
// its contents. The false numbers are values that no device sends: far too large, negative, or all ones.
void change(std::uint32_t lie, Random &random, crn_wire_header &header, std::vector<std::uint8_t> &payload)
{
    const std::size_t size = payload.size(),
                      place = size > 0 ? random.below(static_cast<std::uint32_t>(size)) : 0;
    const auto fill = [&](std::uint8_t first, std::uint8_t rest) {
        for (std::size_t i = place; i < std::min(size, place + 4); i++)
            payload[i] = i + 1 == place + 4 ? first : rest;
    };
    switch (lie) {
    case lie_scene_is_there:
    case lie_scene_is_another:
    case lie_upload_is_there:
        claim_scene(lie, payload);
        break;
    case 0:
        payload.resize(size / 2);
        break;
    case 1:
        payload.resize(std::min<std::size_t>(size + 1 + random.below(40), CRN_WIRE_PAYLOAD_MAX));
        break;
    case 2:
        header.type = static_cast<std::uint16_t>(random.next());
        break;
    case 3:
        header.answers = static_cast<std::uint16_t>(header.answers + 1 + random.below(9));
        break;
    case 4:
        fill(0xff, 0xff);
        break;
    case 5:
        fill(0x80, 0x00);
        break;
    case 6:
        fill(0x7f, 0xff);
        break;
    case 7: // the first count or tick
        for (std::size_t i = 0; i < std::min<std::size_t>(size, 2); i++)
            payload[i] = static_cast<std::uint8_t>(random.next());
        break;
    default:
        for (std::uint8_t &byte : payload) byte = static_cast<std::uint8_t>(random.next());
    }
}

} // namespace

std::vector<std::uint8_t> lie_of(const std::vector<std::uint8_t> &frame, std::uint32_t lie,
                                 std::uint64_t seed)
{
    const auto decoder = std::make_unique<crn_wire_decoder>();
    crn_wire_decoder_init(decoder.get());
    bool is_frame = false;
    for (std::uint8_t byte : frame) is_frame = crn_wire_decoder_push(decoder.get(), byte) == CRN_WIRE_FRAME;
    if (!is_frame) return frame;
    Random random(seed * 1000 + lie);
    crn_wire_header header = decoder->header;
    std::vector<std::uint8_t> payload(decoder->payload, decoder->payload + decoder->payload_bytes);
    change(lie, random, header, payload);
    std::vector<std::uint8_t> lied(CRN_WIRE_FRAME_MAX);
    lied.resize(crn_wire_frame_encode(&header, payload.data(), payload.size(), lied.data(), lied.size()));
    return lied;
}

void FaultyPipe::arm(const Fault &fault)
{
    fault_ = fault;
    is_armed_ = fault.is_group("link.") || fault.is_group("device.");
    has_struck_ = false;
    written_ = read_ = 0;
}

void FaultyPipe::plug()
{
    is_cut_ = false;
    stall_ms_ = 0;
    std::uint8_t lost[4096];
    while (inner_.read(lost) > 0) {
    }
    for (Bytes &held : held_) held.clear();
    partial_.clear();
    ready_.clear();
}

void FaultyPipe::tick()
{
    if (stall_ms_ > 0) stall_ms_--;
}

bool FaultyPipe::strikes(bool to_host, std::uint32_t count)
{
    return is_armed_ && !has_struck_ && to_host == fault_.to_host && count == fault_.at;
}

std::vector<FaultyPipe::Bytes> FaultyPipe::struck(Bytes frame)
{
    has_struck_ = true;
    const std::uint32_t size = static_cast<std::uint32_t>(frame.size());
    Random random(fault_.seed * 7919u + fault_.at);
    if (fault_.is("link.drop")) return {};
    if (fault_.is("link.duplicate")) return {frame, frame};
    if (fault_.is("link.truncate")) return {Bytes(frame.begin(), frame.end() - std::min(fault_.value, size))};
    if (fault_.is("link.flip")) {
        const std::uint32_t bit = fault_.value % (8 * size);
        frame[bit / 8] = static_cast<std::uint8_t>(frame[bit / 8] ^ (1u << (bit % 8)));
        return {frame};
    }
    if (fault_.is("link.garbage")) {
        Bytes noise(fault_.value);
        for (std::uint8_t &byte : noise) byte = static_cast<std::uint8_t>(random.next());
        return {noise, frame};
    }
    if (fault_.is("link.reorder")) {
        held_[fault_.to_host] = frame;
        return {};
    }
    if (fault_.is("link.stall")) stall_ms_ = fault_.value;
    if (fault_.is("link.cut")) {
        is_cut_ = true;
        return {Bytes(frame.begin(), frame.begin() + std::min(fault_.value, size))};
    }
    if (fault_.is("device.lies")) return {lie_of(frame, fault_.value, fault_.seed + fault_.at)};
    return {frame};
}

void FaultyPipe::write(std::span<const std::uint8_t> bytes)
{
    if (is_cut_) gone();
    Bytes frame(bytes.begin(), bytes.end()), late = std::exchange(held_[0], {});
    if (stall_ms_ > 0) return; // a host whose program is suspended sends nothing
    if (strikes(false, ++written_)) {
        for (const Bytes &part : struck(frame)) {
            inner_.write(part);
            delivered_ += part == frame;
        }
        if (stall_ms_ > 0) return;
    } else {
        inner_.write(frame);
        delivered_++;
    }
    if (!late.empty()) inner_.write(late);
}

// Splits the device's bytes into frames, and applies the fault to the one frame that the fault's line of text
// names.
void FaultyPipe::take_from_device()
{
    std::uint8_t bytes[4096];
    for (std::size_t count = inner_.read(bytes); count > 0; count = inner_.read(bytes)) {
        for (std::size_t i = 0; i < count && !is_cut_; i++) {
            partial_.push_back(bytes[i]);
            if (bytes[i] != 0) continue;
            const Bytes frame = std::exchange(partial_, {}), late = std::exchange(held_[1], {});
            const std::vector<Bytes> parts =
                strikes(true, ++read_) ? struck(frame) : std::vector<Bytes>{frame};
            for (const Bytes &part : parts) ready_.insert(ready_.end(), part.begin(), part.end());
            ready_.insert(ready_.end(), late.begin(), late.end());
        }
    }
}

std::size_t FaultyPipe::read(std::span<std::uint8_t> bytes)
{
    if (stall_ms_ > 0) return 0;
    if (!is_cut_) take_from_device();
    const std::size_t count = std::min(bytes.size(), ready_.size());
    std::copy_n(ready_.begin(), count, bytes.begin());
    ready_.erase(ready_.begin(), ready_.begin() + static_cast<std::ptrdiff_t>(count));
    return count;
}

} // namespace hil
