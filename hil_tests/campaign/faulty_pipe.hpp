// A pipe to a device with one fault in it: it counts frames each way and does to one of them what the fault
// says. A lying device is a pipe, too: the frame is taken apart, changed, and put together again with a good
// CRC.
#pragma once
#include "hil_tests/campaign/fault.hpp"
#include "host/link/transport.hpp"
#include <deque>

namespace hil
{

class FaultyPipe final : public crn::Transport
{
  public:
    explicit FaultyPipe(crn::Transport &inner) : inner_(inner) {}

    void arm(const Fault &fault); // frames count from here on
    void plug();                  // a cut cable is whole again; what was on its way is lost
    bool has_struck() const { return has_struck_; }
    std::uint32_t frames_written() const { return written_; }
    std::uint32_t delivered() const { return delivered_; } // frames that reached the device whole
    void tick();                                           // a millisecond of a stall

    void write(std::span<const std::uint8_t> bytes) override;
    std::size_t read(std::span<std::uint8_t> bytes) override;
    void pass_time_ms(std::uint32_t milliseconds) override { inner_.pass_time_ms(milliseconds); }

  private:
    using Bytes = std::vector<std::uint8_t>;
    bool strikes(bool to_host, std::uint32_t count);
    std::vector<Bytes> struck(Bytes frame); // what is sent instead of it
    void take_from_device();

    crn::Transport &inner_;
    Fault fault_{};
    bool is_armed_ = false, has_struck_ = false, is_cut_ = false;
    std::uint32_t written_ = 0, read_ = 0, delivered_ = 0, stall_ms_ = 0;
    Bytes held_[2]; // a frame that waits for its successor, to the device and to the host
    Bytes partial_; // of the device's stream, up to its next zero
    std::deque<std::uint8_t> ready_;
};

// The frame as a liar would send it, with a good CRC.
std::vector<std::uint8_t> lie_of(const std::vector<std::uint8_t> &frame, std::uint32_t lie,
                                 std::uint64_t seed);

} // namespace hil
