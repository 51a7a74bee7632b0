// The image on an emulated Cortex-M7, in the emulator's time: a millisecond is 500,000 instructions. Bytes,
// state reports and requests pass the image's own USB stack.
#pragma once
#include "hil_tests/hours/bus_host.hpp"
#include "hil_tests/hours/frames.hpp"
#include "hil_tests/hours/station.hpp"
#include "host/link/emulator.hpp"
#include <memory>

namespace hours
{

class EmulatedBoard final : public Station
{
  public:
    EmulatedBoard(std::uint64_t seed, std::uint64_t begin_ms); // throws EmulatorError, std::runtime_error
    ~EmulatedBoard() override;
    const char *kind() const override { return "m7"; }
    void pass_ms(std::uint32_t milliseconds) override;
    void stall(std::uint32_t milliseconds) override;
    void pull_cable(std::uint32_t milliseconds) override;
    void restart(std::uint32_t milliseconds) override;
    const Ledger &look() override;
    bool is_sound() override;
    std::uint64_t simulated_ms() const override { return time_ms_; }
    std::uint32_t stack_free() override;

  private:
    void write(std::span<const std::uint8_t> bytes) override;
    std::size_t read(std::span<std::uint8_t> bytes) override;

    bool wait_a_little();
    void pass_frames();
    void poll_bus();
    void begin_life();
    void plug();
    void drop_waiting();
    std::uint32_t edges_done();

    Frames frames_;
    crn::Emulator emulator_;
    std::unique_ptr<BusHost> bus_;
    crn_port_outputs outputs_{};
    std::uint64_t begin_ms_, time_ms_ = 0; // of the rig; at the beginning, and since then
    std::uint64_t frames_seen_ = 0;
    int looks_ = 0;
    std::uint32_t edge_begin_ = 0; // the page's number of the edge at power-up
    std::uint64_t edges_this_life_ = 0;
    std::uint64_t reports_ = 0, edges_at_plug_ = 0; // since the cable is in
};

} // namespace hours
