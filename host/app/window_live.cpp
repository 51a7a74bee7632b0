#include "host/app/window_live.hpp"
#include "host/link/usb_devices.hpp"
#include "host/patient/balloon.hpp"
#include "host/rig/presence.hpp"
#include "host/session/run.hpp"
#include <algorithm>
#include <chrono>
#include <cmath>

namespace crn
{

constexpr std::int32_t inflator_max_kPa = 4000; // the largest value that a device accepts (docs/wire.md)
namespace
{

RecordingHeader header_of(const Device &device, const SceneFile &scene, const std::vector<Instrument> &tools,
                          const crn_wire_entry &entry, const std::vector<StentDesign> &stents)
{
    return {device.identity().core_version,
            device.identity().schema_hash,
            static_cast<std::uint32_t>(scene.bytes.size()),
            scene.crc32,
            scene.path,
            "live",
            tools,
            entry,
            device.rig(),
            stents};
}

} // namespace

LiveSession::LiveSession(const SceneFile &scene, const std::vector<Instrument> &tools,
                         const crn_wire_entry &entry, const std::string &record,
                         const PictureSettings &pictures, const std::vector<RoomCommand> &begin,
                         const DeviceChoice &choice)
    : settings_(pictures), choice_(choice), device_(scene, tools, entry, host_rig(), choice),
      anatomy_(read_anatomy(pictures)), patient_(make_patient(pictures, anatomy_, tools)),
      pictures_(pictures, tools, *patient_, anatomy_), hands_(tools.size()),
      has_balloon_(balloon_tool(tools).has_value())
{
    if (!record.empty()) {
        recorder_ =
            std::make_unique<Recorder>(record, header_of(device_, scene, tools, entry, pictures.stents));
    }
    for (const RoomCommand &command : begin) pass(0, command);
    device_.link().read_nodes();
    picture();
}

void LiveSession::inflate(std::int32_t kPa_per_s)
{
    inflation_kPa_per_s_ = has_balloon_ ? kPa_per_s : 0;
    if (kPa_per_s != 0 && !has_balloon_) pictures_.show_refusal(state_.tick, no_balloon_text);
}

void LiveSession::choose_tool(std::size_t tool, bool all)
{
    pictures_.choose_tool(tool, all);
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

void LiveSession::order(const crn_wire_order &order)
{
    if (!choice_.free_run) return orders_.add(order);
    try {
        if (fault_.empty()) device_.ask([&](Link &link) { link.give_orders({1, {order}}); });
    } catch (const LinkError &error) {
        fault_ = error.what();
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

void LiveSession::annotate(const std::string &notice, const std::vector<std::string> &panel)
{
    pictures_.annotate(notice, panel);
    pictures_.redraw(frame_);
}

std::uint32_t LiveSession::batch_size(std::uint32_t wanted)
{
    const std::uint32_t tick = device_.link().tick();
    const std::uint32_t to_picture = pictures_.next_tick() - tick;
    const std::uint32_t to_snapshot = Recorder::snapshot_every_ticks - tick % Recorder::snapshot_every_ticks;
    static_assert(ContactFigures::look_every_ticks ==
                  HandGrip::look_every_ticks); // batches end at its multiples
    return std::min({wanted, to_picture, to_snapshot, grip_.batch_max(tick),
                     static_cast<std::uint32_t>(Link::steps_max)});
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
            input.hands[k] = {hands_[k].translation_counts(), hands_[k].rotation_counts()};
        }
        inflator_milli_kPa_ =
            std::clamp(inflator_milli_kPa_ + inflation_kPa_per_s_, 0, inflator_max_kPa * 1000);
        input.inflator_raw = inflator_milli_kPa_ / 1000;
        orders_.move_into(input.orders);
        patient_->give_orders(input.orders);
        inputs_.push_back(grip_.hold(input));
    }
    const bool is_picture_due = link.tick() + count == pictures_.next_tick();
    const auto states = device_.step(inputs_, is_picture_due);
    for (std::size_t i = 0; i < states.size(); ++i) {
        state_ = states[i];
        grip_.feel(state_);
        figures_.take(state_);
        if (recorder_) recorder_->tick(inputs_[i], states[i]);
        patient_->tick(inputs_[i], states[i]);
    }
    record_state();
    if (link.tick() % ContactFigures::look_every_ticks == 0)
        device_.ask([&](Link &asked) { contacts_.take(asked.read_contacts()); });
    if (is_picture_due) picture();
    if (figures_.range.is_left()) stop_out_of_range();
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
    if (device_.link().nodes().tick != shown) picture();
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
        // valid range, and the recording ends at that tick.
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

void LiveSession::picture()
{
    const crn_wire_tick_input input = inputs_.empty() ? crn_wire_tick_input{} : inputs_.back();
    frame_ = session_frame(device_, state_, input);
    const Presence presence(choice_.free_run && device_.has_its_own_clock() ? &device_.link() : nullptr);
    patient_->look(frame_.wire);
    pictures_.frame(frame_);
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
    patient_->look(frame_.wire);
    pictures_.frame(frame_);
    pictures_.finish();
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
