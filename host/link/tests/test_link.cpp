// These tests check the following. Whatever bytes were lost, cut or repeated, the message HELLO must begin a
// working conversation, so that nobody has to unplug the cable. A late answer is not taken for the answer to
// the present request. A device that sends bytes without end causes an error. The recording contains every
// tick that the host received.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <functional>
#include <string>
#include <thread>

#include "firmware/tests/reference/long_run.h"
#include "host/link/link.hpp"
#include "host/rig/presence.hpp"

extern "C" {
#include <cmocka.h>
}

namespace
{

// Simulates a device that sends prepared messages, either as answers to the host's last frame or without a
// request.
class TalkingDevice final : public crn::Transport
{
  public:
    TalkingDevice() { crn_wire_decoder_init(&decoder_); }

    void write(std::span<const std::uint8_t> bytes) override
    {
        for (std::uint8_t byte : bytes) {
            if (crn_wire_decoder_push(&decoder_, byte) != CRN_WIRE_FRAME) continue;
            asked = decoder_.header.sequence;
            asked_type = decoder_.header.type;
            if (on_frame) on_frame();
        }
    }
    std::size_t read(std::span<std::uint8_t> bytes) override
    {
        if (ready_.empty() && on_silence) on_silence();
        const std::size_t count = std::min(bytes.size(), ready_.size());
        std::copy_n(ready_.begin(), count, bytes.begin());
        ready_.erase(ready_.begin(), ready_.begin() + static_cast<std::ptrdiff_t>(count));
        return count;
    }
    void pass_time_ms(std::uint32_t) override {}

    void raw(std::initializer_list<std::uint8_t> bytes) { ready_.insert(ready_.end(), bytes); }
    template <class Message, class Put>
    void say(std::uint16_t type, std::uint16_t answers, const Message &message, Put put)
    {
        std::vector<std::uint8_t> payload(CRN_WIRE_PAYLOAD_MAX), frame(CRN_WIRE_FRAME_MAX);
        crn_wire_writer writer = crn_wire_writer_make(payload.data(), payload.size());
        assert_true(put(&writer, &message));
        const crn_wire_header header = {++sequence_, answers, type};
        frame.resize(
            crn_wire_frame_encode(&header, payload.data(), writer.length, frame.data(), frame.size()));
        ready_.insert(ready_.end(), frame.begin(), frame.end());
    }
    void greet()
    {
        crn_wire_hello_reply reply{};
        reply.accepted = 1;
        say(CRN_WIRE_TYPE_hello_reply, asked, reply, crn_wire_put_hello_reply);
    }
    void status(std::uint16_t answers, std::uint32_t tick)
    {
        crn_wire_status status{};
        status.tick = tick;
        say(CRN_WIRE_TYPE_status, answers, status, crn_wire_put_status);
    }
    void refuse(std::uint16_t answers)
    {
        const crn_wire_reject reject = {CRN_WIRE_TYPE_command, CRN_REJECT_WRONG_STATE, 0, 0};
        say(CRN_WIRE_TYPE_reject, answers, reject, crn_wire_put_reject);
    }
    void live(std::uint32_t first, std::uint16_t count)
    {
        crn_wire_live live{};
        live.ticks_count = count;
        for (std::uint16_t i = 0; i < count; i++) live.ticks[i].state.tick = first + i;
        say(CRN_WIRE_TYPE_live, 0, live, crn_wire_put_live);
    }

    std::function<void()> on_frame, on_silence;
    std::uint16_t asked = 0, asked_type = 0;

  private:
    crn_wire_decoder decoder_;
    std::deque<std::uint8_t> ready_;
    std::uint16_t sequence_ = 0;
};

// Returns the text of the error with which `call` ends; empty if there is no error.
std::string error_of(const std::function<void()> &call)
{
    try {
        call();
    } catch (const crn::LinkError &error) {
        return error.what();
    }
    return "";
}

bool contains(const std::string &text, const char *part)
{
    return text.find(part) != std::string::npos;
}

// In this test the device restarted in the middle of a frame. The host's decoder holds the first half of the
// interrupted frame. The device's reply follows directly, without the zero byte that would have ended the
// interrupted frame.
void hello_finds_the_device_behind_half_a_frame(void **)
{
    TalkingDevice device;
    crn::Link link(device);
    device.raw({7, 1, 2, 3});
    assert_true(contains(error_of([&] { link.read_status(); }), "does not answer"));
    device.on_frame = [&] { device.greet(); };
    assert_string_equal(error_of([&] { link.hello(); }).c_str(), "");
    device.raw({9, 1, 2, 3}); // the same when the half frame comes just before the reply
    assert_string_equal(error_of([&] { link.hello(); }).c_str(), "");
}

// Answers, refusals and damaged messages of an earlier conversation do not disturb the new one.
void hello_is_deaf_to_what_was_before(void **)
{
    TalkingDevice device;
    crn::Link link(device);
    device.on_frame = [&] {
        const auto old = static_cast<std::uint16_t>(device.asked - 1);
        device.refuse(old);
        device.status(old, 5);
        device.say(CRN_WIRE_TYPE_ticks, old, crn_wire_hash64{1, 2}, crn_wire_put_hash64);
        device.say(0x7777, 0, crn_wire_hash64{1, 2}, crn_wire_put_hash64);
        device.greet();
    };
    assert_string_equal(error_of([&] { link.hello(); }).c_str(), "");
    device.on_frame = [&] { device.refuse(device.asked); };
    assert_true(contains(error_of([&] { link.hello(); }), "WRONG_STATE"));
}

// A refusal may arrive after the host gave up waiting for its request; the host must not take it for the
// answer to the next request. A refusal of the present request is the answer to it, even when the refusal
// names an earlier frame of the same request.
void a_late_refusal_is_not_taken_for_an_answer(void **)
{
    TalkingDevice device;
    crn::Link link(device);
    assert_true(contains(error_of([&] { link.stop(); }), "does not answer"));
    device.on_frame = [&] {
        device.refuse(static_cast<std::uint16_t>(device.asked - 1));
        device.refuse(0);
        device.status(device.asked, 3);
    };
    assert_string_equal(error_of([&] { link.stop(); }).c_str(), "");
    device.on_frame = [&] { device.refuse(device.asked); };
    assert_true(contains(error_of([&] { link.stop(); }), "WRONG_STATE"));
    device.on_frame = [&] {
        if (device.asked_type == CRN_WIRE_TYPE_snapshot_begin) device.status(device.asked, 0);
        if (device.asked_type == CRN_WIRE_TYPE_snapshot_chunk) device.refuse(device.asked);
        if (device.asked_type == CRN_WIRE_TYPE_snapshot_end) device.status(device.asked, 0);
    };
    const std::vector<std::uint8_t> snapshot(100);
    assert_true(contains(error_of([&] { link.write_snapshot(snapshot); }), "WRONG_STATE"));
}

void a_device_that_talks_without_end_is_left_with_an_error(void **)
{
    TalkingDevice device;
    crn::Link link(device);
    device.on_silence = [&] { device.say(CRN_WIRE_TYPE_notice, 0, crn_wire_notice{}, crn_wire_put_notice); };
    // On a slow machine the time limit is reached before the limit on the number of frames; both limits cause
    // an error.
    const auto is_left = [&](const std::string &error) {
        return contains(error, "without end") ||
               (REFERENCE_RUN(10) < 10 && contains(error, "kept the host waiting"));
    };
    assert_true(is_left(error_of([&] { link.read_status(); })));
    assert_true(is_left(error_of([&] { link.free_run(5); })));
    assert_true(is_left(error_of([&] { link.hello(); })));
    assert_true(link.take_notices().size() == crn::Link::notices_max);
}

// In this test the device sends endless zeros, endless noise, or one byte now and then. None of the bytes
// that the device sends is a message, and each call must end after a bounded number of bytes or a bounded
// time.
void a_device_that_never_frames_is_left_with_an_error(void **)
{
    for (const unsigned char byte : {0x00, 0x55, 0xff}) {
        TalkingDevice device;
        crn::Link link(device);
        std::size_t given = 0;
        device.on_silence = [&] {
            for (int i = 0; i < 4096; i++) device.raw({byte});
            given += 4096;
        };
        const std::string text = error_of([&] { link.hello(); });
        if (!contains(text, "no message") || !contains(text, "Remedy")) fail_msg("'%s'", text.c_str());
        assert_in_range(given, crn::Link::bytes_without_frame_max, crn::Link::bytes_without_frame_max + 8192);
        assert_true(contains(error_of([&] { link.read_status(); }), "no message"));
        assert_true(contains(error_of([&] { link.free_run(5); }), "no message"));
    }
}

// In this test the time budget is 60 ms, and all requests share it: the second request gets the time that the
// first one has left over.
void a_device_that_keeps_its_host_waiting_is_left_with_an_error(void **)
{
    TalkingDevice device;
    crn::Link link(device, std::chrono::milliseconds(60));
    device.on_silence = [&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        device.raw({0});
    };
    const auto begin = std::chrono::steady_clock::now();
    const std::string text = error_of([&] { link.read_status(); });
    if (!contains(text, "kept the host waiting") || !contains(text, "status")) fail_msg("'%s'", text.c_str());
    for (int i = 0; i < 5; i++) assert_false(error_of([&] { link.read_status(); }).empty());
    // The first call takes 0.26 s, and each later call takes 0.2 s; a busy machine may take longer.
    assert_true(std::chrono::steady_clock::now() - begin < std::chrono::seconds(5));
}

// A snapshot must have the size that the device announced, and must not be larger than the largest snapshot
// of a correct device.
void a_snapshot_beyond_its_size_is_refused(void **)
{
    TalkingDevice device;
    crn::Link link(device);
    crn_wire_snapshot_begin begin = {0, 1000, 0};
    crn_wire_snapshot_chunk chunk{};
    chunk.data_count = CRN_WIRE_MAX_snapshot_chunk_data;
    device.on_frame = [&] {
        device.say(CRN_WIRE_TYPE_snapshot_begin, device.asked, begin, crn_wire_put_snapshot_begin);
        device.say(CRN_WIRE_TYPE_snapshot_chunk, device.asked, chunk, crn_wire_put_snapshot_chunk);
    };
    assert_true(contains(error_of([&] { link.read_snapshot(); }), "snapshot_chunk"));
    begin.snapshot_bytes = 0xffffffff;
    assert_true(contains(error_of([&] { link.read_snapshot(); }), "snapshot_begin"));
}

// The answer to the command STOP arrives before the ticks that were still in the device's queue. The ticks
// that were still in the queue arrive later, and are the last ticks of the recording.
void ticks_that_come_behind_the_answer_to_stop_are_recorded(void **)
{
    TalkingDevice device;
    crn::Link link(device);
    device.on_frame = [&] { device.status(device.asked, 0); };
    link.start();
    device.on_frame = nullptr;
    device.live(1, 16);
    assert_int_equal(link.free_run(0).size(), 16);
    device.on_frame = [&] {
        device.live(17, 2); // together with the answer
        device.status(device.asked, 21);
        device.live(19, 3); // and behind it
    };
    assert_int_equal(link.stop().tick, 21);
    const auto last = link.free_run(0);
    assert_int_equal(last.size(), 5);
    assert_int_equal(last.front().tick, 17);
    assert_int_equal(last.back().tick, 21);
    assert_int_equal(link.ticks_missing(), 0);
    assert_int_equal(link.free_run(0).size(), 0);
}

// A device sends the hash of every hundredth tick without a request. Another hash without a request would
// hide the one that a recording needs.
void a_hash_of_another_tick_needs_a_request(void **)
{
    TalkingDevice device;
    device.on_frame = [&] { device.greet(); };
    crn::Link link(device);
    device.on_frame = [&] {
        device.say(CRN_WIRE_TYPE_hash64, 0, crn_wire_hash64{100, 7}, crn_wire_put_hash64);
        device.say(CRN_WIRE_TYPE_hash64, device.asked, crn_wire_hash64{150, 8}, crn_wire_put_hash64);
    };
    assert_int_equal(link.read_hash64().tick, 150);
    assert_int_equal(link.last_hash64()->tick, 100);
    device.on_frame = [&] {
        device.say(CRN_WIRE_TYPE_hash64, 0, crn_wire_hash64{50, 7}, crn_wire_put_hash64);
        device.status(device.asked, 200);
    };
    try {
        link.read_status();
        fail_msg("the hash of tick 50 was accepted");
    } catch (const crn::LinkError &error) {
        assert_non_null(std::strstr(error.what(), "tick 50 without a request"));
    }
}

// While the host makes a picture, it can be silent for longer than the 30 ms after which a device reduces its
// forces to zero. While the host makes a picture, an object of class Presence sends heartbeats, but only for
// a limited time. The test counts frames instead of measuring time: three frames arrive while the Presence
// object exists, and none arrives after its limit.
void a_busy_host_is_present_for_half_a_second(void **)
{
    TalkingDevice device;
    std::atomic<int> heard = 0;
    device.on_frame = [&] { heard++; };
    crn::Link link(device);
    link.send_input({});
    heard = 0;
    {
        const crn::Presence presence(&link);
        for (int i = 0; i < 1000 && heard < 3; i++)
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        assert_true(heard >= 3);
        assert_int_equal(device.asked_type, CRN_WIRE_TYPE_input);
        std::this_thread::sleep_for(2 * crn::Presence::limit);
        const int last = heard;
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        assert_int_equal(heard, last);
    }
    const int last = heard;
    {
        const crn::Presence nobody(nullptr);
    }
    assert_int_equal(heard, last);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(hello_finds_the_device_behind_half_a_frame),
        cmocka_unit_test(hello_is_deaf_to_what_was_before),
        cmocka_unit_test(a_late_refusal_is_not_taken_for_an_answer),
        cmocka_unit_test(a_device_that_talks_without_end_is_left_with_an_error),
        cmocka_unit_test(a_device_that_never_frames_is_left_with_an_error),
        cmocka_unit_test(a_device_that_keeps_its_host_waiting_is_left_with_an_error),
        cmocka_unit_test(a_snapshot_beyond_its_size_is_refused),
        cmocka_unit_test(a_hash_of_another_tick_needs_a_request),
        cmocka_unit_test(a_busy_host_is_present_for_half_a_second),
        cmocka_unit_test(ticks_that_come_behind_the_answer_to_stop_are_recorded),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
