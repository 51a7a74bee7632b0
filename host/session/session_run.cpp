#include "host/session/session_run.hpp"
#include "host/base/interrupt.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace crn
{

SessionRun::SessionRun(SteppedDevice &device, Patient &patient, const Session &session, Recorder *recorder,
                       FrameSink *sink, const RunSettings &settings)
    : device_(device), link_(device.link()), patient_(patient),
      player_(session, device.positions(), settings.tips ? &settings.tips->map() : nullptr),
      recorder_(recorder), sink_(sink), settings_(settings)
{
    for (const RoomCommand &command : settings_.begin) pass(0, command);
    pass_commands(0);
    look_when_due();
}

bool SessionRun::is_over() const
{
    return is_batch_done() && (player_.is_done() || is_interrupted() || figures_.range.is_placed());
}

void SessionRun::advance_to(std::uint32_t tick)
{
    while (!is_over() && link_.tick() < tick) batch(tick);
}

bool SessionRun::advance_to_pulse(std::uint32_t tick)
{
    while (!is_over() && link_.tick() < tick) {
        batch(tick);
        if (has_pulse()) return true;
    }
    return false;
}

RunResult SessionRun::end()
{
    RunResult result;
    result.figures = figures_;
    result.contacts = contacts_;
    result.was_interrupted = !player_.is_done() && !figures_.range.is_left();
    result.given_up_lines = player_.given_up_lines();
    for (std::size_t k = 0; k < figures_.tools.size(); k++) result.grips.push_back(grip_.figures(k));
    result.steered = player_.steered();
    result.expected = player_.expected();
    result.failures = player_.failures();
    result.hash = device_.read_hash64().hash;
    device_.ask([&](Link &link) {
        link.read_nodes();
        result.faults = link.read_fault_log();
    });
    result.resumes = device_.resumes();
    const WireFrame wire = session_frame(device_, state_, {}).wire;
    patient_.look(wire);
    if (settings_.tips) result.tips = settings_.tips->at(wire);
    if (recorder_) recorder_->finish(link_.tick(), result.hash);
    if (sink_) sink_->finish();
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin_;
    result.seconds = taken.count();
    if (settings_.shows_progress) std::fprintf(stderr, "\r%60s\r", "");
    return result;
}

// Returns the number of ticks that can be stepped in one batch, before the script, the patient or the
// observer needs the session's state.
std::uint32_t SessionRun::batch_size() const
{
    const std::uint32_t tick = link_.tick();
    std::uint32_t count =
        std::min(SessionPlayer::observe_every_ticks - tick % SessionPlayer::observe_every_ticks,
                 grip_.batch_max(tick));
    count = std::min(count, next_stop() - tick);
    return std::min(count, Recorder::snapshot_every_ticks - tick % Recorder::snapshot_every_ticks);
}

// Returns the next tick at which the patient or the observer needs the shape of the tools.
std::uint32_t SessionRun::next_stop() const
{
    return std::min(patient_.next_look(), sink_ ? sink_->next_tick() : UINT32_MAX);
}

// Makes the inputs of a batch. A command of the script ends the batch, because the patient must receive the
// command before the tick after it.
void SessionRun::begin_batch()
{
    const std::uint32_t begin = link_.tick();
    const std::uint32_t count = batch_size();
    inputs_.clear();
    stepped_ = 0;
    while (inputs_.size() < count && !player_.is_done()) {
        inputs_.push_back(grip_.hold(player_.next()));
        patient_.give_orders(inputs_.back().orders);
        if (pass_commands(begin + static_cast<std::uint32_t>(inputs_.size()))) break;
    }
    const std::uint32_t end = begin + static_cast<std::uint32_t>(inputs_.size());
    is_look_due_ = player_.wants_tips() && end % SessionPlayer::observe_every_ticks == 0;
    wants_nodes_ = is_look_due_ || end == next_stop();
}

// Steps a batch, or the part of it that ends at `limit`. The inputs of the whole batch are made at its begin,
// so a caller that stops inside it changes nothing.
void SessionRun::batch(std::uint32_t limit)
{
    if (is_batch_done()) begin_batch();
    const std::size_t left = inputs_.size() - stepped_;
    const std::size_t count = std::min<std::size_t>(left, limit - link_.tick());
    const std::span<const crn_wire_tick_input> part = std::span(inputs_).subspan(stepped_, count);
    const auto states = device_.step(part, wants_nodes_ && count == left);
    for (std::size_t i = 0; i < states.size(); i++) {
        figures_.take(states[i]);
        grip_.feel(states[i]);
        state_ = states[i];
        if (recorder_) recorder_->tick(part[i], states[i]);
        patient_.tick(part[i], states[i]);
        if (sink_) sink_->tick(part[i], states[i]);
        player_.answer_exchange(states[i].exchange);
    }
    stepped_ += count;
    if (is_batch_done()) end_batch();
}

void SessionRun::end_batch()
{
    look_at_contacts(); // first, as in a replay: it may injure the patient
    if (link_.tick() % SessionPlayer::observe_every_ticks == 0) look(is_look_due_);
    if (figures_.range.wants_place(link_.tick(), player_.is_done()))
        device_.ask([&](Link &link) { figures_.range.find_place(link); });
    record_state();
    look_when_due();
}

// Reads the state of the session on which the script's decisions depend. Expectations about contrast
// medium and stents are checked with the values at exactly this tick, whatever pictures are made.
void SessionRun::look(bool has_nodes)
{
    const std::vector<double> lengths_m = inserted();
    std::vector<TipPlace> tips;
    if (has_nodes) {
        const SessionFrame frame = session_frame(device_, state_, inputs_.back());
        if (settings_.tips) tips = settings_.tips->at(frame.wire);
        if (player_.expects()) patient_.look_at_vessels(frame.wire);
    }
    player_.observe({lengths_m, tips, settings_.witness, link_.tick()});
}

// Passes the script's commands to the X-ray room, where they take effect from this tick on; returns true
// if there were any commands.
bool SessionRun::pass_commands(std::uint32_t tick)
{
    const std::vector<RoomCommand> commands = player_.take_commands();
    for (const RoomCommand &command : commands) pass(tick, command);
    return !commands.empty();
}

void SessionRun::pass(std::uint32_t tick, const RoomCommand &command)
{
    if (recorder_) recorder_->command(tick, command);
    patient_.command(tick, command);
}

void SessionRun::look_at_contacts()
{
    static_assert(ContactFigures::look_every_ticks ==
                  SessionPlayer::observe_every_ticks); // batches end at its multiples
    if (link_.tick() % ContactFigures::look_every_ticks != 0) return;
    device_.ask([&](Link &link) {
        const crn_wire_contacts &contacts = link.read_contacts();
        contacts_.take(contacts);
        if (sink_) sink_->contacts(contacts);
        if (!patient_.can_be_injured() || !patient_.feel(contacts)) return;
        link.read_nodes();
        patient_.locate(session_frame(device_, state_, {}).wire);
    });
}

void SessionRun::record_state()
{
    if (!recorder_) return;
    const auto hash = device_.last_hash64();
    if (hash && hash->tick > hash_tick_) {
        hash_tick_ = hash->tick;
        recorder_->hash(hash->tick, hash->hash);
    }
    if (link_.tick() % Recorder::snapshot_every_ticks != 0) return;
    recorder_->snapshot(link_.tick(), device_.read_snapshot());
}

void SessionRun::look_when_due()
{
    const std::uint32_t tick = link_.tick();
    if (tick != next_stop()) return;
    const bool is_wanted = sink_ && sink_->next_tick() == tick;
    // A look can become due in the batch that ends here, as when a catheter's tip enters the vessels.
    if (!wants_nodes_) device_.ask([](Link &link) { link.read_nodes(); });
    const SessionFrame frame =
        session_frame(device_, state_, inputs_.empty() ? crn_wire_tick_input{} : inputs_.back());
    patient_.look(frame.wire);
    if (!is_wanted) return;
    sink_->frame(frame);
    show_progress();
}

void SessionRun::show_progress()
{
    if (!settings_.shows_progress || link_.tick() < progress_tick_) return;
    progress_tick_ = link_.tick() + 1000;
    std::string lengths;
    for (double m : inserted())
        lengths += (lengths.empty() ? "" : " / ") + std::to_string(std::lround(m * 1e3));
    std::fprintf(stderr, "\r%6.1f s, %s mm inserted", link_.tick() * 1e-3, lengths.c_str());
}

bool SessionRun::has_pulse() const
{
    const std::vector<RoomEvent> &events = patient_.room().events();
    return std::any_of(events.begin(), events.end(), [&](const RoomEvent &event) {
        return event.kind == RoomEvent::Kind::pulse && event.tick == link_.tick();
    });
}

std::vector<double> SessionRun::inserted() const
{
    std::vector<double> lengths_m;
    for (const ToolFigures &tool : figures_.tools) lengths_m.push_back(tool.inserted_m);
    return lengths_m;
}

} // namespace crn
