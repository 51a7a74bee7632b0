#include "hil_tests/hours/emulated_board.hpp"
#include "hil_tests/l1/bench_server.hpp"
#include "host/base/format.hpp"
#include "host/base/interrupt.hpp"
#include <cmath>
#include <stdexcept>
#include <sys/prctl.h>
#include <unistd.h>

namespace hours
{

namespace
{

constexpr int icount_shift = 1; // 500 instructions per us
constexpr int looks_before_sleep = 2000, looks_max = 1'000'000;
constexpr useconds_t sleep_us = 1;
constexpr std::uint64_t poll_every = 16; // frames: reports wait in the device for 64 ms
constexpr int naks_of_nothing = 4;       // the device answers the bus between two pieces of its work
constexpr int retries_max = 100000;
constexpr double edge_max_us = 1000.0;
constexpr std::uint32_t stack_free_min = 1024;

} // namespace

EmulatedBoard::EmulatedBoard(std::uint64_t seed, std::uint64_t begin_ms)
    : Station(seed), frames_(seed), emulator_({.icount_shift = icount_shift, .serial = "HOURS-0002"}),
      begin_ms_(begin_ms)
{
    prctl(PR_SET_TIMERSLACK, 1UL); // short sleeps while the emulator works
    bus_ = std::make_unique<BusHost>(
        emulator_.memory(), [this] { return wait_a_little(); }, [this] { looks_ = 0; });
    begin_life();
}

EmulatedBoard::~EmulatedBoard() = default;

bool EmulatedBoard::wait_a_little()
{
    if (++looks_ < looks_before_sleep) return true;
    usleep(sleep_us);
    return looks_ < looks_max && !crn::is_interrupted();
}

// --- power and cable ---

void EmulatedBoard::begin_life()
{
    edge_begin_ = rig_read(&emulator_.page().device.edge_done);
    edges_this_life_ = 0;
    plug();
}

void EmulatedBoard::plug()
{
    bus_->plug();
    reports_ = 0;
    edges_at_plug_ = edges_this_life_;
}

// What waits in the device for a host that goes away is no loss.
void EmulatedBoard::drop_waiting()
{
    ledger_.reports_dropped += edges_this_life_ - edges_at_plug_ - reports_;
}

void EmulatedBoard::pull_cable(std::uint32_t milliseconds)
{
    look();
    drop_waiting();
    bus_->unplug();
    pass_ms(milliseconds);
    plug();
}

void EmulatedBoard::restart(std::uint32_t milliseconds)
{
    look();
    drop_waiting();
    bus_->unplug();
    outputs_ = {};
    for (std::uint32_t i = 0; i < milliseconds; i++) {
        time_ms_++;
        pass_frames();
        plant_.step(outputs_);
    }
    emulator_.power_cycle();
    ledger_.restarts++;
    begin_life();
}

// --- time ---

void EmulatedBoard::poll_bus()
{
    for (int naks = 0; naks < naks_of_nothing; naks++) {
        for (; bus_->poll_report(); naks = 0) {
            reports_++;
            ledger_.reports++;
        }
    }
    while (bus_->poll_stream()) {
    }
}

void EmulatedBoard::pass_frames()
{
    while (frames_.next_ps() <= static_cast<std::int64_t>(time_ms_) * ps_per_ms) {
        frames_.begin_next();
        if (!bus_->is_plugged()) continue;
        ledger_.frames++;
        frames_seen_ = frames_.count();
        if (frames_seen_ % poll_every == 0) poll_bus();
    }
}

void EmulatedBoard::pass_ms(std::uint32_t milliseconds)
{
    for (std::uint32_t i = 0; i < milliseconds; i++) {
        time_ms_++;
        pass_frames();
        hil::make_rig_edge(emulator_, plant_.inputs(), static_cast<std::uint32_t>(begin_ms_ + time_ms_));
        edges_this_life_++;
        ledger_.edges++;
        const double us = rig_read(&emulator_.page().device.edge_counts) * crn::Emulator::count_ns * 1e-3;
        ledger_.overruns += us > edge_max_us;
        ledger_.edge_us_max = std::max(ledger_.edge_us_max, us);
        outputs_ = hil::take_rig_outputs(emulator_.page());
        plant_.step(outputs_);
    }
}

// The timer of a halted processor makes no edges; the device finds the gap in its clock.
void EmulatedBoard::stall(std::uint32_t milliseconds)
{
    for (std::uint32_t i = 0; i < milliseconds; i++) {
        time_ms_++;
        pass_frames();
        plant_.step(outputs_);
    }
    pass_ms(1);
}

// --- the stream ---

void EmulatedBoard::write(std::span<const std::uint8_t> bytes)
{
    if (!bus_->is_plugged()) throw crn::LinkError("the cable is out");
    while (!bytes.empty()) {
        const auto packet = bytes.first(std::min(bytes.size(), BusHost::packet_bytes));
        for (int i = 0; !bus_->send(packet); i++) {
            if (i == retries_max) throw crn::LinkError("the device takes no more bytes");
            while (bus_->poll_stream()) {
            }
        }
        bytes = bytes.subspan(packet.size());
    }
}

std::size_t EmulatedBoard::read(std::span<std::uint8_t> bytes)
{
    if (!bus_->is_plugged()) throw crn::LinkError("the cable is out");
    for (int naks = 0; !bus_->has_bytes() && naks < naks_of_nothing; naks++) {
        while (bus_->poll_stream()) {
        }
    }
    return bus_->read(bytes);
}

// --- the judge ---

std::uint32_t EmulatedBoard::edges_done()
{
    return rig_read(&emulator_.page().device.edge_done) - edge_begin_;
}

bool EmulatedBoard::is_sound()
{
    return stack_free() >= stack_free_min && emulator_.page().device.crash.exception == 0;
}

std::uint32_t EmulatedBoard::stack_free()
{
    return rig_read(&emulator_.page().device.stack_free);
}

// One report is made at every edge, so the reports that have come are the edges that the device has counted;
// the host's controller counts the frames.
const Ledger &EmulatedBoard::look()
{
    if (bus_->is_plugged()) poll_bus();
    const std::uint32_t done = edges_done();
    if (done != edges_this_life_)
        note(crn::formatted("%llu edges, of which the device did %u",
                            static_cast<unsigned long long>(edges_this_life_), done));
    ledger_.edges_done = ledger_.edges - edges_this_life_ + done;
    const std::uint64_t counted = edges_at_plug_ + reports_;
    if (bus_->is_plugged() && counted != done) {
        ledger_.reports_lost += counted > done ? counted - done : done - counted;
        note(crn::formatted("%u edges made %llu state reports", done,
                            static_cast<unsigned long long>(counted)));
    }
    ledger_.us_wraps = (begin_ms_ + time_ms_) * 1000 / us_per_wrap - begin_ms_ * 1000 / us_per_wrap;
    ledger_.frame_wraps = frames_.count() / frame_numbers;
    if (bus_->is_plugged() && frames_seen_ == frames_.count()) {
        const std::uint64_t halted_ms = time_ms_ - edges_this_life_; // without power, or halted
        const double time = static_cast<double>(time_ms_);
        const double found = static_cast<double>(counted + halted_ms) - static_cast<double>(frames_seen_);
        ledger_.drift_ms =
            std::max(ledger_.drift_ms,
                     std::abs(found - (time - frames_.at(static_cast<std::int64_t>(time_ms_) * ps_per_ms))));
    }
    if (!is_sound()) note("the stack has reached the variables, or the processor raised an exception");
    return ledger_;
}

} // namespace hours
