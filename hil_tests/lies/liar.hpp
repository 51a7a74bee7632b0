// Simulates a rig that sends one false message (a lie). The rig consists of the firmware's own device and a
// filter that changes the device's messages. The simulated bus holds its own lock while it calls the
// functions of this rig.
#pragma once
#include "firmware/port/sim/sim.h"
#include "hil_tests/lies/lie.hpp"
#include "shared/wire/wire_frame.h"
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace hil
{

using Bytes = std::vector<std::uint8_t>;

// A frame taken apart; it can be put together again with a good CRC.
struct Frame {
    crn_wire_header header{};
    Bytes payload;
};
Bytes encode(const Frame &frame);

class Liar
{
  public:
    // `frames` is the number of frames that a device without a lie sends while this command runs. If a lie
    // names a frame with a higher number than `frames`, the lie is applied to an earlier frame. The function
    // `struck` is called when the lie is first applied.
    Liar(const Lie &lie, unsigned frames, crn_sim *sim, std::function<void()> struck);
    void take(std::span<const std::uint8_t> bytes);
    std::size_t give(std::span<std::uint8_t> bytes);

  private:
    using Clock = std::chrono::steady_clock;

    void pull();
    void say(const Bytes &bytes);
    void pass(Frame frame, const Bytes &raw);
    void strike();
    bool is_only_slow() const; // it passes the device's messages on
    bool lie_about_frame(const Frame &frame, const Bytes &raw);
    bool lie_about_snapshot(const Frame &frame, const Bytes &raw);
    bool lie_about_message(Frame &frame);
    void forge();
    std::size_t stream(std::span<std::uint8_t> bytes);
    std::size_t drip(std::span<std::uint8_t> bytes);

    Lie lie_;
    unsigned place_;
    crn_sim *sim_;
    std::function<void()> struck_;
    bool has_struck_ = false, is_streaming_ = false;
    unsigned frames_ = 0, seen_ = 0; // frames sent, and messages of the lie's type among them
    std::unique_ptr<crn_wire_decoder> from_device_, from_host_;
    crn_wire_header asked_{};
    Bytes partial_, same_, held_, last_ticks_;
    std::vector<Frame> snapshot_; // under way
    std::deque<std::uint8_t> out_, flood_;
    std::uint32_t random_ = 1;
    Clock::time_point next_drip_{};
    std::deque<std::pair<Clock::time_point, Bytes>> late_;
};

// Changes one field of a message as the given lie states; returns false if the lie does not concern this
// message. (liar_fields.cpp)
bool change_field(const Lie &lie, Frame &frame, const Bytes &last_ticks);
// Returns the type of the messages whose field the lie changes, or 0 if the lie applies to messages of every
// type.
std::uint16_t type_of(const Lie &lie);
// Returns an empty message of the given type, which the rig then fills and sends without a request.
Frame empty_message(std::uint16_t type);

} // namespace hil
