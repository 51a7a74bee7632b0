#include "host/session/replay.hpp"
#include "host/base/format.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/number_text.hpp"
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <thread>

namespace crn
{

namespace
{

using Clock = std::chrono::steady_clock;
constexpr std::uint32_t ticks_per_second = 1000;
constexpr std::uint32_t batch_ticks = 16;

class Replayer
{
  public:
    Replayer(Device &device, const Recording &recording, Patient *patient, FrameSink *sink,
             const ReplaySettings &settings)
        : device_(device), link_(device.link()), recording_(recording), patient_(patient), sink_(sink),
          settings_(settings)
    {
    }

    ReplayResult run()
    {
        go_to_start();
        pass_commands();
        has_started_ = true;
        begin_ = Clock::now();
        begin_tick_ = link_.tick();
        look_when_due(false);
        while (link_.tick() < recording_.ticks.size() && !is_interrupted() &&
               !result_.first_difference_tick) {
            batch();
            keep_pace();
        }
        result_.was_interrupted = link_.tick() < recording_.ticks.size() && !result_.first_difference_tick;
        result_.tick = link_.tick();
        result_.line = line_of(state_);
        result_.hash = link_.read_hash64().hash;
        result_.faults = link_.read_fault_log();
        compare_hash(result_.tick, result_.hash);
        if (patient_) look_at_the_end();
        if (sink_) sink_->finish();
        result_.seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
        return result_;
    }

  private:
    void go_to_start()
    {
        const double last = static_cast<double>(recording_.ticks.size());
        const auto wanted =
            static_cast<std::uint32_t>(std::clamp(settings_.from_s * ticks_per_second, 0.0, last));
        const std::uint32_t known = patient_ && patient_->needs_beginning() ? 0 : first_injection();
        const RecordedSnapshot *snapshot = recording_.snapshot_before(std::min(wanted, known));
        if (snapshot) device_.restore(snapshot->bytes);
        while (link_.tick() < wanted && !is_interrupted() && !result_.first_difference_tick) {
            const std::uint32_t look = patient_ ? patient_->next_vessel_look() : UINT32_MAX;
            std::size_t count =
                std::min<std::size_t>({batch_ticks - link_.tick() % batch_ticks, wanted - link_.tick(),
                                       recording_.ticks_to_resume(link_.tick())});
            if (look > link_.tick()) count = std::min<std::size_t>(count, look - link_.tick());
            if (patient_ && command_ < recording_.commands.size())
                count = std::min<std::size_t>(count, std::max<std::size_t>(command_ticks(), 1));
            step(count, false);
            look_at_contacts();
            pass_commands();
            if (!patient_ || link_.tick() < patient_->next_vessel_look()) continue;
            link_.read_nodes();
            patient_->look_at_vessels(session_frame(device_, state_, inputs_.back()).wire);
        }
    }

    // Contrast medium injected before the start of the replay may still be in the vessels, so the patient is
    // computed from the first injection on.
    std::uint32_t first_injection() const
    {
        for (const RecordedCommand &recorded : recording_.commands)
            if (patient_ && recorded.command.action == RoomAction::inject) return recorded.tick;
        return UINT32_MAX;
    }

    std::size_t command_ticks() const
    {
        const std::uint32_t next = recording_.commands[command_].tick;
        return next > link_.tick() ? next - link_.tick() : 0;
    }

    std::size_t batch_size() const
    {
        const std::uint32_t tick = link_.tick();
        std::size_t count =
            std::min<std::size_t>(batch_ticks - tick % batch_ticks, recording_.ticks.size() - tick);
        count = std::min<std::size_t>(count, recording_.ticks_to_resume(tick));
        if (settings_.speed.is_paused)
            count = std::min<std::size_t>(count, ticks_per_second - tick % ticks_per_second);
        if (settings_.speed.is_paused && tick % ticks_per_second < batch_ticks) count = 1;
        if (next_stop() != UINT32_MAX) count = std::min<std::size_t>(count, next_stop() - tick);
        if (command_ < recording_.commands.size())
            count = std::min<std::size_t>(count, recording_.commands[command_].tick - tick);
        return count;
    }

    // Returns the next tick at which the patient or the observer needs the shape of the tools, or UINT32_MAX
    // if no such tick is left.
    std::uint32_t next_stop() const
    {
        return std::min(patient_ ? patient_->next_look() : UINT32_MAX,
                        sink_ ? sink_->next_tick() : UINT32_MAX);
    }

    void batch()
    {
        const std::size_t count = batch_size();
        const std::size_t end = link_.tick() + count;
        const bool has_nodes = end == next_stop() || (patient_ && is_command_due(end));
        step(count, has_nodes);
        look_at_contacts();
        pass_commands();
        look_when_due(has_nodes);
    }

    // If the device disappeared and returned at this tick, the session continued from another state, which
    // the recording contains.
    void go_on_from_resume()
    {
        const RecordedSnapshot *resumed = recording_.resumed_at(link_.tick());
        if (resumed) device_.restore(resumed->bytes);
    }

    void step(std::size_t count, bool want_nodes)
    {
        go_on_from_resume();
        inputs_.clear();
        for (std::size_t i = 0; i < count; i++) inputs_.push_back(recording_.ticks[link_.tick() + i].input);
        for (const crn_wire_tick_state &state : link_.step(inputs_, want_nodes)) {
            result_.figures.take(state);
            if (patient_) patient_->tick(recording_.ticks[state.tick - 1].input, state);
            if (sink_) sink_->tick(recording_.ticks[state.tick - 1].input, state);
            state_ = state;
            compare_lanes(state);
        }
        if (result_.figures.range.wants_place(link_.tick(), link_.tick() == recording_.ticks.size()))
            result_.figures.range.find_place(link_);
        const auto hash = link_.last_hash64();
        if (hash && hash->tick > hash_tick_) {
            hash_tick_ = hash->tick;
            compare_hash(hash->tick, hash->hash);
        }
    }

    void look_at_contacts()
    {
        static_assert(ContactFigures::look_every_ticks == batch_ticks); // batches end at its multiples
        const bool measures = settings_.measures_contacts && has_started_;
        const bool feels = patient_ && patient_->can_be_injured();
        if (!(measures || feels) || link_.tick() % batch_ticks != 0) return;
        const crn_wire_contacts &contacts = link_.read_contacts();
        if (measures) result_.contacts.take(contacts);
        if (measures && sink_) sink_->contacts(contacts);
        if (!feels || !patient_->feel(contacts)) return;
        link_.read_nodes();
        patient_->locate(session_frame(device_, state_, inputs_.back()).wire);
    }

    void compare_lanes(const crn_wire_tick_state &state)
    {
        if (!settings_.verifies || result_.first_difference_tick) return;
        const RecordedTick &recorded = recording_.ticks[state.tick - 1];
        result_.ticks_compared++;
        if (recorded.hash_lane[0] == state.hash_lane0 && recorded.hash_lane[1] == state.hash_lane1) return;
        result_.first_difference_tick = state.tick;
        const std::string text = formatted("hash lanes are %08x %08x, recorded %08x %08x",
                                           unsigned{state.hash_lane0}, unsigned{state.hash_lane1},
                                           unsigned{recorded.hash_lane[0]}, unsigned{recorded.hash_lane[1]});
        result_.difference = text;
    }

    void compare_hash(std::uint32_t tick, std::uint64_t hash)
    {
        if (!settings_.verifies || result_.first_difference_tick) return;
        for (const RecordedHash &recorded : recording_.hashes) {
            if (recorded.tick != tick) continue;
            result_.hashes_compared++;
            if (recorded.hash == hash) continue;
            result_.first_difference_tick = tick;
            result_.difference = "full hash is " + hex_text(hash) + ", recorded " + hex_text(recorded.hash);
            return;
        }
    }

    // A look can become due in the batch that ends here, as when a catheter's tip enters the vessels.
    void look_when_due(bool has_nodes)
    {
        const std::uint32_t tick = link_.tick();
        if (tick < next_stop()) return;
        const bool is_wanted = sink_ && tick >= sink_->next_tick();
        if (!has_nodes) link_.read_nodes();
        const SessionFrame frame =
            session_frame(device_, state_, inputs_.empty() ? crn_wire_tick_input{} : inputs_.back());
        if (patient_) patient_->look(frame.wire);
        if (is_wanted) sink_->frame(frame);
    }

    void look_at_the_end()
    {
        link_.read_nodes();
        patient_->look(session_frame(device_, state_, {}).wire);
    }

    bool is_command_due(std::size_t tick) const
    {
        return command_ < recording_.commands.size() && recording_.commands[command_].tick <= tick;
    }

    // Passes the recorded commands up to the present tick to the X-ray room and the patient.
    void pass_commands()
    {
        for (; is_command_due(link_.tick()); command_++) {
            const RecordedCommand &recorded = recording_.commands[command_];
            if (patient_) patient_->command(recorded.tick, recorded.command);
        }
    }

    void keep_pace()
    {
        if (settings_.speed.is_paused && link_.tick() % ticks_per_second == 0) halt();
        if (settings_.speed.factor <= 0.0) return;
        const double seconds = (link_.tick() - begin_tick_) * 1e-3 / settings_.speed.factor;
        const auto due =
            begin_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
        std::this_thread::sleep_until(due);
    }

    void halt() const
    {
        if (!settings_.waits_for_enter) {
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
            return;
        }
        std::fprintf(stderr, "paused at %.3f s; Enter continues ", link_.tick() * 1e-3);
        std::string line;
        std::getline(std::cin, line);
    }

    Device &device_;
    Link &link_;
    const Recording &recording_;
    Patient *patient_;
    FrameSink *sink_;
    const ReplaySettings &settings_;
    ReplayResult result_;
    std::vector<crn_wire_tick_input> inputs_;
    crn_wire_tick_state state_{};
    Clock::time_point begin_;
    std::uint32_t begin_tick_ = 0, hash_tick_ = 0;
    bool has_started_ = false; // the start of the replay has been reached
    std::size_t command_ = 0;  // the next one that has not been passed on
};

} // namespace

std::optional<ReplaySpeed> replay_speed(const std::string &text)
{
    if (text == "fast") return ReplaySpeed{};
    if (text == "slow") return ReplaySpeed{0.5, false};
    if (text == "paused") return ReplaySpeed{0.0, true};
    double factor = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), factor);
    if (error != std::errc() || end != text.data() + text.size() || !(factor >= 0.001 && factor <= 1000.0))
        return {};
    return ReplaySpeed{factor, false};
}

ReplayResult replay_recording(Device &device, const Recording &recording, Patient *patient, FrameSink *sink,
                              const ReplaySettings &settings)
{
    return Replayer(device, recording, patient, sink, settings).run();
}

} // namespace crn
