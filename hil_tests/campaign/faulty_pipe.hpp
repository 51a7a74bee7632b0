// This class passes bytes between the host and a device, and injects one fault into them. The class counts
// the frames of each direction and applies the fault to one frame. A lying device is also modelled by the
// pipe: the frame is taken apart, changed, and put together again with a good CRC.
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

    void arm(const Fault &fault); // frames are counted from here on
    void plug();                  // repairs a cut cable; bytes that were under way are lost
    bool has_struck() const { return has_struck_; }
    std::uint32_t frames_written() const { return written_; }
    std::uint32_t delivered() const { return delivered_; } // frames that reached the device complete
    void tick();                                           // a millisecond of a stall

    void write(std::span<const std::uint8_t> bytes) override;
    std::size_t read(std::span<std::uint8_t> bytes) override;
    void pass_time_ms(std::uint32_t milliseconds) override { inner_.pass_time_ms(milliseconds); }

  private:
    using Bytes = std::vector<std::uint8_t>;
    bool strikes(bool to_host, std::uint32_t count);
    std::vector<Bytes> struck(Bytes frame); // the frames that are sent instead
    void take_from_device();

    crn::Transport &inner_;
    Fault fault_{};
    bool is_armed_ = false, has_struck_ = false, is_cut_ = false;
    std::uint32_t written_ = 0, read_ = 0, delivered_ = 0, stall_ms_ = 0;
    Bytes held_[2]; // a frame that waits for its successor: one to the device and one to the host
    Bytes partial_; // part of the device's stream, up to its next zero
    std::deque<std::uint8_t> ready_;
};

// The frame as a lying device would send it, with a good CRC.
std::vector<std::uint8_t> lie_of(const std::vector<std::uint8_t> &frame, std::uint32_t lie,
                                 std::uint64_t seed);

} // namespace hil
