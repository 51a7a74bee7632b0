// The device in this process. Time is counted in picoseconds of the device's crystal: an edge of its timer
// comes every 10^9 ps exactly, and the frames of USB a little sooner or later.
#pragma once
#include "hil_tests/hours/bus_host.hpp"
#include "hil_tests/hours/device.h"
#include "hil_tests/hours/frames.hpp"
#include "hil_tests/hours/station.hpp"
#include <memory>
#include <vector>

namespace hours
{

struct BoardSettings {
    std::uint64_t seed = 1;
    // Of the ticks, one in so many takes longer than a millisecond (1.1 to 1.9 ms); 0: none does.
    std::uint32_t late_every = 20000;
    // Where the clocks begin: so that a short run also meets their wraps.
    std::uint64_t begin_ms = 0;
};

class Board : public Station
{
  public:
    explicit Board(const BoardSettings &settings); // throws std::bad_alloc, std::runtime_error
    ~Board() override;
    const char *kind() const override { return "host"; }
    void pass_ms(std::uint32_t milliseconds) override;
    void stall(std::uint32_t milliseconds) override;
    void pull_cable(std::uint32_t milliseconds) override;
    void restart(std::uint32_t milliseconds) override;
    const Ledger &look() override;
    bool is_sound() override { return hours_device_is_sound(device_.get()); }
    std::uint64_t simulated_ms() const override { return edges_made_; }

  private:
    struct Close {
        void operator()(hours_device *device) const { hours_device_destroy(device); }
    };
    // Transport
    void write(std::span<const std::uint8_t> bytes) override;
    std::size_t read(std::span<std::uint8_t> bytes) override;

    hours_hardware hardware();
    std::uint32_t now_us() const;
    std::uint32_t draw_work_us(bool is_ticking);
    void pass_ps(std::int64_t ps); // the hardware alone
    void make_edge();
    void make_frame();
    void run_until(std::int64_t ps); // the processor, too
    void finish_edges();
    void settle();
    void poll_bus();
    void begin_life();
    void end_life();
    void check_frames(const hours_counts &counts);
    void check_reports(const hours_counts &counts);
    void plug();

    BoardSettings settings_;
    hil::Random random_;
    Frames frames_;
    std::vector<std::uint8_t> mailbox_;
    std::unique_ptr<hours_device, Close> device_;
    std::unique_ptr<BusHost> bus_;
    crn_port_outputs outputs_{};
    bool has_power_ = false;

    std::int64_t now_ps_ = 0, edge_ps_ = ps_per_ms; // edge_ps_: of the next one
    std::uint64_t edges_made_ = 0;                  // by the crystal, whether or not the device has power
    std::uint64_t frames_seen_ = 0;                 // the last frame that reached the device
    int polls_due_ = 0, waits_ = 0;
    std::uint32_t backlog_us_ = 0;

    // of this life of the device
    std::uint64_t edges_begin_ = 0;
    std::uint32_t edges_given_ = 0, overruns_given_ = 0;
    struct Look { // when the device last read the register of frames
        bool is_there = false;
        std::int64_t ps = 0;
        std::uint64_t frames_begin = 0, frames = 0; // at the first reading, and now
        std::uint32_t edges = 0;
    } look_;
    // since the cable is in
    std::uint64_t reports_ = 0;
    hours_counts plugged_{};
    Ledger before_; // the sums of the device's earlier lives
};

} // namespace hours
