#include "host/live/live_session.hpp"
#include "host/link/usb_devices.hpp"
#include "host/patient/balloon.hpp"
#include "host/picture/session_pictures.hpp"
#include "host/rig/presence.hpp"
#include "host/session/run.hpp"
#include <algorithm>
#include <chrono>
#include <cmath>

namespace crn
{

namespace
{

constexpr std::int32_t inflator_max_kPa = 4000; // the largest value that a device accepts (docs/wire.md)
constexpr std::uint32_t look_every_ticks = 20;  // the window is told the shape of the tools so often
// When the user drags a tool with the mouse, the hand moves at most 0.2 m and 2.5 turns per second.
constexpr std::int32_t drag_um_per_tick = 200, drag_turn_per_tick = counts_per_turn / 400;
// The measuring chamber of automatic exposure uses only one thread. A second thread would have to wait for
// the threads that draw, and the physics would have to wait for the second thread.
constexpr int chamber_threads = 1;
constexpr std::int32_t drag_max_counts = 100'000; // 10 cm, or one and a half turns, may wait

} // namespace

LiveSession::LiveSession(const SceneFile &scene, const std::vector<Instrument> &tools,
                         const crn_wire_entry &entry, const std::string &record,
                         const PictureSettings &pictures, const std::vector<RoomCommand> &begin,
                         const DeviceChoice &choice, bool keeps_all_pictures)
    : settings_(pictures), choice_(choice), device_(scene, tools, entry, host_rig(), choice, pictures.line),
      anatomy_(read_anatomy(pictures)), patient_(make_patient(pictures, anatomy_, tools, chamber_threads)),
      pictures_(pictures, tools, patient_->scene(), anatomy_, keeps_all_pictures),
      hands_(device_.positions()), dragged_(device_.positions()), to_drag_(device_.positions())
{
    if (!record.empty()) {
        recorder_ = std::make_unique<Recorder>(record, device_.recording_header("live", pictures.stents));
    }
    for (const RoomCommand &command : begin) pass(0, command);
    device_.link().read_nodes();
    look();
}

void LiveSession::lead(std::span<const HandSpeed> speeds)
{
    for (std::size_t k = 0; k < hands_.size() && k < speeds.size(); ++k)
        hands_[k].set_speed(speeds[k].push_um_per_s * counts_per_m / 1'000'000, speeds[k].turn_counts_per_s);
}

void LiveSession::drag(std::size_t tool, std::int32_t translation_counts, std::int32_t rotation_counts)
{
    if (tool >= to_drag_.size()) return;
    crn_wire_hand &waiting = to_drag_[tool];
    waiting.translation_counts =
        std::clamp(waiting.translation_counts + translation_counts, -drag_max_counts, drag_max_counts);
    waiting.rotation_counts =
        std::clamp(waiting.rotation_counts + rotation_counts, -drag_max_counts, drag_max_counts);
}

// Returns the part of a drag with the mouse that one tick carries out.
crn_wire_hand LiveSession::step_of_drag(crn_wire_hand &waiting)
{
    const crn_wire_hand step = {std::clamp(waiting.translation_counts, -drag_um_per_tick, drag_um_per_tick),
                                std::clamp(waiting.rotation_counts, -drag_turn_per_tick, drag_turn_per_tick)};
    waiting.translation_counts -= step.translation_counts;
    waiting.rotation_counts -= step.rotation_counts;
    return step;
}

void LiveSession::inflate(std::int32_t kPa_per_s)
{
    const bool has_balloon = balloon_tool(patient_->tools()).has_value();
    inflation_kPa_per_s_ = has_balloon ? kPa_per_s : 0;
    if (kPa_per_s != 0 && !has_balloon) refused_ = {no_balloon_text, state_.tick};
}

void LiveSession::pass(std::uint32_t tick, const RoomCommand &command)
{
    if (recorder_) recorder_->command(tick, command);
    patient_->command(tick, command);
}

// The picture of the present tick has already been made, so a command takes effect in the next tick.
void LiveSession::command(const RoomCommand &command)
{
    const std::uint32_t pedal = command.action == RoomAction::fluoro_pedal    ? CRN_WIRE_BUTTON_XRAY
                                : command.action == RoomAction::acquire_pedal ? CRN_WIRE_BUTTON_CINE
                                                                              : 0;
    buttons_ = command.values[0] == 1 ? buttons_ | pedal : buttons_ & ~pedal;
    pass((choice_.free_run ? led_tick_ : device_.link().tick()) + 1, command);
}

void LiveSession::exchange(std::uint8_t position, std::uint8_t tool)
{
    order(crn_wire_order_of_exchange({position, tool}));
}

void LiveSession::order(const crn_wire_order &order)
{
    if (!choice_.free_run) return orders_.add(order);
    // If a rig has disappeared, or already has too many waiting commands, this command is not sent; the user
    // may repeat it.
    try {
        if (fault_.empty()) device_.link().give_orders({1, {order}});
    } catch (const DeviceLost &) {
        refused_ = {"NOT DONE - the rig is disconnected", state_.tick};
    } catch (const LinkError &error) {
        if (error.reject.code == 0)
            fault_ = error.what();
        else
            refused_ = {std::string("NOT DONE - ") + error.what(), state_.tick};
    }
}

// In the mode LOCKSTEP a rig reports the state of its pedals only when the host requests it.
void LiveSession::look_at_pedals()
{
    if (!choice_.is_usb) return;
    crn_wire_sensors sensors{};
    device_.ask([&](Link &link) { sensors = link.read_sensors(); });
    for (const RoomCommand &change : rig_pedals_.changes(sensors.buttons)) command(change);
    if (const auto injection = rig_syringe_.change(device_.link().tick(), sensors.syringe_counts))
        command(*injection);
}

std::uint32_t LiveSession::next_look() const
{
    const std::uint32_t shown = frame_.wire.tick - frame_.wire.tick % look_every_ticks + look_every_ticks;
    return std::min(patient_->next_look(), shown);
}

std::uint32_t LiveSession::batch_size(std::uint32_t wanted)
{
    const std::uint32_t tick = device_.link().tick();
    const std::uint32_t to_look = next_look() - tick;
    const std::uint32_t to_snapshot = Recorder::snapshot_every_ticks - tick % Recorder::snapshot_every_ticks;
    static_assert(ContactFigures::look_every_ticks ==
                  HandGrip::look_every_ticks); // batches end at its multiples
    return std::min(
        {wanted, to_look, to_snapshot, grip_.batch_max(tick), static_cast<std::uint32_t>(Link::steps_max)});
}

bool LiveSession::advance(std::uint32_t ticks)
{
    try {
        if (choice_.free_run) {
            if (fault_.empty()) advance_rig(ticks);
            return fault_.empty();
        }
        look_at_pedals();
        while (fault_.empty() && ticks > 0) {
            const std::uint32_t count = batch_size(ticks);
            batch(count);
            ticks -= count;
        }
    } catch (const LinkError &error) {
        fault_ = error.what();
    }
    return fault_.empty();
}

void LiveSession::batch(std::uint32_t count)
{
    Link &link = device_.link();
    inputs_.clear();
    for (std::uint32_t i = 0; i < count; ++i) {
        crn_wire_tick_input input{};
        input.hands_count = static_cast<std::uint16_t>(hands_.size());
        input.buttons = buttons_;
        for (std::size_t k = 0; k < hands_.size(); ++k) {
            hands_[k].advance_tick();
            const crn_wire_hand step = step_of_drag(to_drag_[k]);
            dragged_[k].translation_counts += step.translation_counts;
            dragged_[k].rotation_counts += step.rotation_counts;
            input.hands[k] = {hands_[k].translation_counts() + dragged_[k].translation_counts,
                              hands_[k].rotation_counts() + dragged_[k].rotation_counts};
        }
        inflator_milli_kPa_ =
            std::clamp(inflator_milli_kPa_ + inflation_kPa_per_s_, 0, inflator_max_kPa * 1000);
        input.inflator_raw = inflator_milli_kPa_ / 1000;
        orders_.move_into(input.orders);
        patient_->give_orders(input.orders);
        inputs_.push_back(grip_.hold(input));
    }
    const bool is_look_due = link.tick() + count == next_look();
    const auto states = device_.step(inputs_, is_look_due);
    for (std::size_t i = 0; i < states.size(); ++i) {
        state_ = states[i];
        grip_.feel(state_);
        figures_.take(state_);
        if (recorder_) recorder_->tick(inputs_[i], states[i]);
        patient_->tick(inputs_[i], states[i]);
    }
    done_tick_ = link.tick();
    record_state();
    if (link.tick() % ContactFigures::look_every_ticks == 0)
        device_.ask([&](Link &asked) { look_at_contacts(asked); });
    if (is_look_due) look();
    if (figures_.range.is_left()) stop_out_of_range();
}

void LiveSession::look_at_contacts(Link &link)
{
    const crn_wire_contacts &contacts = link.read_contacts();
    contacts_.take(contacts);
    if (!patient_->can_be_injured() || !patient_->feel(contacts)) return;
    link.read_nodes();
    patient_->locate(session_frame(device_, state_, inputs_.back()).wire);
}

// A real rig has its own clock, and this function reads that clock once for every redrawn screen. A simulated
// rig advances by the ticks that are due.
void LiveSession::advance_rig(std::uint32_t ticks)
{
    const std::uint32_t shown = device_.link().nodes().tick;
    device_.run_free(choice_.is_usb ? 1 : ticks, *this);
    const auto hash = device_.last_hash64();
    if (recorder_ && hash && hash->tick > hash_tick_ && hash->tick <= led_tick_) {
        hash_tick_ = hash->tick;
        recorder_->hash(hash->tick, hash->hash);
    }
    if (device_.link().nodes().tick != shown) look();
    send_orders(device_.link(), *patient_);
    if (figures_.range.is_left()) stop_out_of_range();
}

// The function ends the recording with the last tick that the device finished. The function stops a rig in
// the mode FREE_RUN, so that its motors get no more power.
void LiveSession::stop_out_of_range()
{
    fault_ = range_notice(*figures_.range.left());
    try {
        if (choice_.free_run) device_.stop_free(*this);
        has_stopped_ = true;
        figures_.range.find_place(device_.link());
    } catch (const LinkError &) {
        // If the device has disappeared in the meantime, the program cannot read where the physics left its
        // valid range; the recording ends at that tick.
    }
}

void LiveSession::tick(const crn_wire_live_tick &tick)
{
    led_tick_ = tick.state.tick;
    state_ = tick.state;
    figures_.take(state_);
    inputs_.assign(1, tick.input);
    if (recorder_) recorder_->tick(tick.input, tick.state);
    patient_->tick(tick.input, tick.state);
    for (const RoomCommand &change : rig_pedals_.changes(tick.input.buttons)) pass(led_tick_ + 1, change);
    if (const auto injection = rig_syringe_.change(led_tick_, tick.input.syringe_counts))
        pass(led_tick_ + 1, *injection);
}

void LiveSession::snapshot(std::uint32_t tick, std::span<const std::uint8_t> bytes)
{
    if (recorder_) recorder_->snapshot(tick, bytes);
}

void LiveSession::resumed(std::uint32_t tick, std::span<const std::uint8_t> bytes)
{
    if (recorder_) recorder_->resumed(tick, bytes);
}

void LiveSession::record_state()
{
    if (!recorder_) return;
    Link &link = device_.link();
    const auto hash = device_.last_hash64();
    if (hash && hash->tick > hash_tick_) {
        hash_tick_ = hash->tick;
        recorder_->hash(hash->tick, hash->hash);
    }
    if (link.tick() % Recorder::snapshot_every_ticks != 0) return;
    recorder_->snapshot(link.tick(), device_.read_snapshot());
}

// Advances the patient to the present tick, and passes the events of the X-ray room to the pictures' thread.
void LiveSession::look()
{
    const crn_wire_tick_input input = inputs_.empty() ? crn_wire_tick_input{} : inputs_.back();
    frame_ = session_frame(device_, state_, input);
    const Presence presence(choice_.free_run && device_.has_its_own_clock() ? &device_.link() : nullptr);
    give_pictures();
    if (observer_) observer_(frame_, *patient_);
}

void LiveSession::give_pictures()
{
    patient_->look(frame_.wire);
    RoomPackage package;
    for (const RoomEvent &event : patient_->room().events()) {
        RoomItem item{event, {}};
        if (event.kind == RoomEvent::Kind::pulse) {
            item.shot = shot_of(*patient_, frame_.wire, event.tick, settings_);
            item.shot->own();
        }
        package.items.push_back(std::move(item));
    }
    package.room = patient_->room();
    package.asked = asked_;
    pictures_.give(std::move(package));
}

SuiteState LiveSession::state() const
{
    SuiteState state;
    state.tick = tick();
    state.room = patient_->room();
    state.frame = frame_;
    state.line = patient_->line();
    state.contrast_ml = patient_->contrast().injected_ml();
    state.contrast_ml_s = patient_->contrast().flow_ml_s();
    state.injection_kPa_per_ml_s = patient_->contrast().injection_kPa_per_ml_s(state_);
    state.inflator_kPa = inflator_milli_kPa_ * 1e-3;
    state.core = state_;
    if (patient_->stents()) state.stent = patient_->stents()->stage_text();
    state.pulse = patient_->monitor();
    state.is_pressure_damped = patient_->catheter_pressure().is_damped();
    state.pressure_tool = patient_->catheter_pressure().tool_name();
    state.notice = patient_->notice();
    state.refused = refused_;
    state.fault = fault_;
    state.has_left_range = figures_.range.is_left();
    return state;
}

void LiveSession::finish()
{
    try {
        if (choice_.free_run && !has_stopped_) device_.stop_free(*this);
        const Hash64 hash = device_.read_hash64();
        end_hash_ = hash.hash;
        if (recorder_) recorder_->finish(hash.tick, hash.hash);
        device_.ask([&](Link &link) {
            link.read_nodes();
            faults_ = link.read_fault_log();
        });
        frame_ = session_frame(device_, state_, inputs_.empty() ? crn_wire_tick_input{} : inputs_.back());
    } catch (const LinkError &) {
        if (fault_.empty()) throw; // after a fault the recording ends where the device disappeared
    }
    recorder_.reset();
    // The final state combines the last finished tick with the last received shape of the tools, because a
    // device that has disappeared sends no later shape.
    frame_.wire.tick = std::max(frame_.wire.tick, state_.tick);
    give_pictures();
    pictures_.stop();
    was_stopped_ = !pictures_.pictures().finish_export(*patient_, files_);
}

RunResult LiveSession::result(const TipPlaces &tips) const
{
    RunResult result;
    result.figures = figures_;
    result.contacts = contacts_;
    result.hash = end_hash_;
    result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    result.faults = faults_;
    result.resumes = device_.resumes();
    result.tips = tips.at(frame_.wire);
    for (std::size_t k = 0; k < figures_.tools.size() && !choice_.free_run; ++k)
        result.grips.push_back(grip_.figures(k));
    return result;
}

} // namespace crn
