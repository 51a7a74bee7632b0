// Runs a session in FREE_RUN, records its ticks, and shows its pictures as they arrive.
#include "host/base/interrupt.hpp"
#include "host/link/usb_devices.hpp"
#include "host/rig/pedals.hpp"
#include "host/rig/presence.hpp"
#include "host/session/run.hpp"
#include <algorithm>
#include <chrono>
#include <cstdio>

namespace crn
{

void send_orders(Link &link, Patient &patient)
{
    crn_wire_order_list orders{};
    patient.give_orders(orders);
    send_orders(link, orders);
}

void send_orders(Link &link, const crn_wire_order_list &orders)
{
    if (orders.items_count == 0) return;
    try {
        link.give_orders(orders);
    } catch (const DeviceLost &) {
        // An error in sending is ignored, because the next request also finds that the device has
        // disappeared, and waits for its return.
    } catch (const LinkError &error) {
        // A device that has just stopped by a fault takes no orders. The next request reports that fault,
        // which is the cause.
        if (error.reject.code != CRN_REJECT_WRONG_STATE) throw;
    }
}

namespace
{

using Clock = std::chrono::steady_clock;

class FreeRunner final : private FreeRunSink
{
  public:
    FreeRunner(Device &device, Patient &patient, Recorder *recorder, FrameSink *sink,
               const RunSettings &settings)
        : device_(device), patient_(patient), recorder_(recorder), sink_(sink), settings_(settings)
    {
    }

    RunResult run(const std::vector<RoomCommand> &at_start, double seconds)
    {
        const Clock::time_point begin = Clock::now();
        const double ticks_wanted = seconds * 1e3;
        for (const RoomCommand &command : at_start) pass(0, command);
        try {
            while ((seconds == 0.0 || figures_.ticks < ticks_wanted) && !is_interrupted() &&
                   !figures_.range.is_left()) {
                device_.run_free(round_ms, *this);
                record_hash();
                picture_when_it_came();
                send_orders(device_.link(), patient_);
                show_progress();
            }
            result_.was_interrupted =
                seconds > 0.0 && figures_.ticks < ticks_wanted && !figures_.range.is_left();
            device_.stop_free(*this);
            if (figures_.range.is_left()) figures_.range.find_place(device_.link());
            result_.hash = device_.read_hash64().hash;
            if (recorder_) recorder_->finish(figures_.ticks, result_.hash);
        } catch (const LinkError &error) {
            result_.stopped_by = error.what(); // the recording ends where the rig stopped
        }
        read_faults();
        look_at_the_end();
        if (sink_) sink_->finish();
        result_.figures = figures_;
        result_.resumes = device_.resumes();
        result_.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
        if (settings_.shows_progress) std::fprintf(stderr, "\r%60s\r", "");
        return result_;
    }

  private:
    static constexpr std::uint32_t round_ms = 8; // forces fade when the host is silent for 30 ms

    void tick(const crn_wire_live_tick &tick) override
    {
        figures_.take(tick.state);
        state_ = tick.state;
        input_ = tick.input;
        result_.late_ticks += (tick.flags & CRN_WIRE_LIVE_LATE) != 0;
        result_.powered_ticks += (tick.flags & CRN_WIRE_LIVE_POWERED) != 0;
        if (recorder_) recorder_->tick(tick.input, tick.state);
        patient_.tick(tick.input, tick.state);
        if (sink_) sink_->tick(tick.input, tick.state);
        for (const RoomCommand &command : pedals_.changes(tick.input.buttons))
            pass(tick.state.tick + 1, command);
        if (const auto injection = syringe_.change(tick.state.tick, tick.input.syringe_counts))
            pass(tick.state.tick + 1, *injection);
    }

    void pass(std::uint32_t tick, const RoomCommand &command)
    {
        if (recorder_) recorder_->command(tick, command);
        patient_.command(tick, command);
    }

    void snapshot(std::uint32_t tick, std::span<const std::uint8_t> bytes) override
    {
        if (recorder_) recorder_->snapshot(tick, bytes);
    }

    void resumed(std::uint32_t tick, std::span<const std::uint8_t> bytes) override
    {
        if (recorder_) recorder_->resumed(tick, bytes);
    }

    // A hash may arrive before the ticks to which it belongs, and those ticks may never arrive. A hash is
    // therefore recorded only after the ticks to which it belongs.
    void record_hash()
    {
        const auto hash = device_.last_hash64();
        if (!recorder_ || !hash || hash->tick <= hash_tick_ || hash->tick > figures_.ticks) return;
        hash_tick_ = hash->tick;
        recorder_->hash(hash->tick, hash->hash);
    }

    void picture_when_it_came()
    {
        const std::uint32_t tick = device_.link().nodes().tick;
        if (tick == picture_tick_) return;
        picture_tick_ = tick;
        result_.pictures++;
        const SessionFrame frame = session_frame(device_, state_, input_);
        const Presence presence(device_.has_its_own_clock() ? &device_.link() : nullptr);
        patient_.look(frame.wire);
        if (sink_) sink_->frame(frame);
    }

    // The last received shape of the tools is used, because a rig that has disappeared sends no other shape.
    void look_at_the_end()
    {
        SessionFrame frame = session_frame(device_, state_, input_);
        frame.wire.tick = std::max(frame.wire.tick, figures_.ticks);
        patient_.look(frame.wire);
        if (sink_) sink_->frame(frame);
    }

    void show_progress()
    {
        if (!settings_.shows_progress || figures_.ticks - shown_tick_ < 1000) return;
        shown_tick_ = figures_.ticks;
        std::fprintf(stderr, "\r%6.1f s, %u pictures", figures_.ticks * 1e-3, unsigned{result_.pictures});
    }

    void read_faults()
    {
        try {
            result_.faults = device_.link().read_fault_log();
        } catch (const LinkError &) {
            // If the rig has disappeared, its fault log cannot be read.
        }
    }

    Device &device_;
    Patient &patient_;
    RigPedals pedals_;
    RigSyringe syringe_;
    Recorder *recorder_;
    FrameSink *sink_;
    const RunSettings &settings_;
    RunResult result_;
    SessionFigures figures_;
    crn_wire_tick_state state_{};
    crn_wire_tick_input input_{};
    std::uint32_t hash_tick_ = 0, picture_tick_ = 0, shown_tick_ = 0;
};

} // namespace

RunResult run_free_session(Device &device, Patient &patient, const std::vector<RoomCommand> &begin,
                           double seconds, Recorder *recorder, FrameSink *sink, const RunSettings &settings)
{
    return FreeRunner(device, patient, recorder, sink, settings).run(begin, seconds);
}

} // namespace crn
