// A device with its rig and its bus, in simulated time. Two crystals make the time: the device's, whose
// milliseconds are the edges of its timer, and the host's, whose milliseconds are the frames of USB.
//
//   Board           the device's app and USB stack in this process        (board.hpp)
//   EmulatedBoard   the image on an emulated Cortex-M7                    (emulated_board.hpp)
//
// Every station keeps a Ledger: what the hardware did, against what the device and the host counted.
#pragma once
#include "hil_tests/plant/plant.hpp"
#include "host/link/transport.hpp"
#include <cstdint>
#include <string>

namespace hours
{

// All counts grow from the start of the station on, over restarts of the device.
struct Ledger {
    std::uint64_t edges = 0, edges_done = 0;     // of the timer; and those that the app has completed
    std::uint64_t ticks = 0;                     // edges with a tick of a running session
    std::uint64_t frames = 0;                    // of the bus that reached the device
    std::uint64_t frames_missed = 0;             // that the device did not count, or counted twice
    double drift_ms = 0.0;                       // worst |edges less frames|, less what the crystals make
    std::uint64_t reports = 0;                   // state reports that arrived
    std::uint64_t reports_dropped = 0;           // that the device dropped while no host polled
    std::uint64_t reports_lost = 0;              // without a reason: none may be
    std::uint64_t overruns = 0;                  // edges that the device noticed late
    std::uint64_t overruns_given = 0;            // edges that the simulated processor made late
    double edge_us_max = 0.0;                    // longest work of an edge, where the device measures it
    std::uint64_t us_wraps = 0, frame_wraps = 0; // of the device's clock, and of the frames' number
    std::uint64_t restarts = 0;
    std::string trouble; // the first violation; empty: none
};

inline constexpr std::uint64_t us_per_wrap = UINT64_C(1) << 32; // of the device's clock: 71.6 minutes

class Station : private crn::Transport
{
  public:
    virtual const char *kind() const = 0;
    crn::Transport &pipe() { return *this; }
    hil::Plant &plant() { return plant_; }
    virtual void pass_ms(std::uint32_t milliseconds) = 0;
    virtual void stall(std::uint32_t milliseconds) = 0;      // the processor stands still, the rig does not
    virtual void pull_cable(std::uint32_t milliseconds) = 0; // it is plugged in again afterwards
    virtual void restart(std::uint32_t milliseconds) = 0;    // no power for so long
    // The ledger with all counts of this moment; checks all relations between them.
    virtual const Ledger &look() = 0;
    virtual bool is_sound() = 0; // false: memory beside the device's, or beyond its stack, was written
    virtual std::uint64_t simulated_ms() const = 0;
    virtual std::uint32_t stack_free()
    {
        return 0;
    } // bytes that the device's stack has never reached; 0: unknown

  protected:
    explicit Station(std::uint64_t seed);  // of the plant
    void note(const std::string &trouble); // the first one stays

    hil::Plant plant_;
    Ledger ledger_;

  private:
    // Transport; the stations have its bytes
    void pass_time_ms(std::uint32_t milliseconds) override { pass_ms(milliseconds); }
    bool has_own_clock() const override { return false; }
};

} // namespace hours
