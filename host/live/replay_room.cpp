#include "host/live/replay_room.hpp"
#include "host/command/cli.hpp"
#include "host/patient/balloon.hpp"
#include "host/patient/pushed_vessels.hpp"
#include "host/picture/session_pictures.hpp"
#include <algorithm>

namespace crn
{
namespace
{

constexpr std::uint32_t batch_ticks = 16, carm_every_ticks = 100;

std::unique_ptr<Device> device_of(const Recording &recording, const SceneFile &scene)
{
    const RecordingHeader &header = recording.header;
    auto device =
        std::make_unique<Device>(scene, header.tools, header.entry, header.rig, DeviceChoice{}, header.line);
    check_core(header, device->identity());
    device->link().read_nodes();
    return device;
}

} // namespace

ReplayRoom::ReplayRoom(const std::string &recording, const std::string &scene, PictureSettings settings)
    : recording_(read_recording(recording)), settings_(std::move(settings)),
      scene_(recorded_scene(recording_.header, scene))
{
    const std::vector<Instrument> &tools = recording_.header.tools;
    settings_.scene_path = scene_.path;
    settings_.stents = recording_.header.stents;
    settings_.line = recording_.header.line;
    settings_.size = held_size(settings_.size);
    if (settings_.bodies_path.empty()) settings_.bodies_path = bodies_beside(scene_.path);
    anatomy_ = read_anatomy(settings_);
    for (const Instrument &tool : tools) looks_.push_back(instrument_look(tool));
    device_ = device_of(recording_, scene_);
    track_device_ = device_of(recording_, scene_);
    patient_ = std::make_unique<Patient>(anatomy_, tools, PatientSettings{"", {}, 2, settings_.line});
    track_patient_ = make_patient(settings_, anatomy_, tools);
    xray_ = std::make_unique<Xray>(patient_->scene(), settings_.threads);
    for (; command_ < recording_.commands.size() && recording_.commands[command_].tick == 0; ++command_)
        track_patient_->command(0, recording_.commands[command_].command);
    look_at_track();
}

ReplayRoom::~ReplayRoom() = default;

std::vector<ReplayMark> ReplayRoom::marks() const
{
    std::vector<ReplayMark> marks;
    const auto change = [&](ReplayMark::Kind kind, std::uint32_t tick, bool begins) {
        const auto open = std::find_if(marks.rbegin(), marks.rend(),
                                       [&](const ReplayMark &mark) { return mark.kind == kind; });
        if (open != marks.rend() && open->end == ticks()) open->end = tick;
        if (begins) marks.push_back({kind, tick, ticks()});
    };
    for (const RecordedCommand &recorded : recording_.commands) {
        const RoomCommand &command = recorded.command;
        if (command.action == RoomAction::fluoro_pedal)
            change(ReplayMark::Kind::fluoro, recorded.tick, command.values[0] == 1);
        else if (command.action == RoomAction::acquire_pedal)
            change(ReplayMark::Kind::acquire, recorded.tick, command.values[0] == 1);
        else if (command.action == RoomAction::inject)
            change(ReplayMark::Kind::injection, recorded.tick, command.values[0] > 0);
    }
    return marks;
}

// Advances a device by the recorded inputs. If the recorded session continued from another state after its
// cable had been unplugged, the recording contains that state.
void ReplayRoom::step_to(Device &device, std::uint32_t tick, crn_wire_tick_state &state) const
{
    std::vector<crn_wire_tick_input> inputs;
    while (device.link().tick() < tick) {
        const std::uint32_t now = device.link().tick();
        if (const RecordedSnapshot *resumed = recording_.resumed_at(now)) device.restore(resumed->bytes);
        const std::uint32_t count = std::min({batch_ticks, tick - now, recording_.ticks_to_resume(now)});
        inputs.clear();
        for (std::uint32_t i = 0; i < count; ++i) inputs.push_back(recording_.ticks[now + i].input);
        state = device.link().step(inputs, now + count == tick).back();
    }
}

void ReplayRoom::look_at_track()
{
    const std::uint32_t tick = track_device_->link().tick();
    const WireFrame wire = session_frame(*track_device_, track_state_, {}).wire;
    track_patient_->look(wire);
    Moment moment;
    moment.carm = track_patient_->room().gantry().carm(track_patient_->room().field_m());
    std::vector<SweptCurve> curves = track_patient_->contrast().curves();
    if (PatientStents *stents = track_patient_->stents()) {
        std::vector<SweptCurve> struts = stents->curves_at(at_rest(wire));
        curves.insert(curves.end(), struts.begin(), struts.end());
    }
    if (!curves.empty()) moment.curves = std::make_shared<const std::vector<SweptCurve>>(std::move(curves));
    const std::lock_guard lock(mutex_);
    moments_[tick] = std::move(moment);
}

bool ReplayRoom::prepare(std::uint32_t count)
{
    Device &device = *track_device_;
    const std::uint32_t end = std::min(ticks(), device.link().tick() + count);
    while (device.link().tick() < end) {
        const std::uint32_t now = device.link().tick();
        std::uint32_t next = std::min(end, now - now % batch_ticks + batch_ticks);
        next = std::min({next, std::max(track_patient_->next_look(), now + 1),
                         now - now % carm_every_ticks + carm_every_ticks,
                         now - now % Patient::feel_every_ticks + Patient::feel_every_ticks});
        if (command_ < recording_.commands.size())
            next = std::min(next, std::max(recording_.commands[command_].tick, now + 1));
        if (const RecordedSnapshot *resumed = recording_.resumed_at(now)) device.restore(resumed->bytes);
        next = std::min(next, now + std::min(recording_.ticks_to_resume(now), batch_ticks));
        std::vector<crn_wire_tick_input> inputs;
        for (std::uint32_t i = now; i < next; ++i) inputs.push_back(recording_.ticks[i].input);
        const auto states = device.link().step(inputs, true);
        for (std::size_t i = 0; i < states.size(); ++i) track_patient_->tick(inputs[i], states[i]);
        track_state_ = states.back();
        feel_walls(device);
        const bool is_commanded =
            command_ < recording_.commands.size() && recording_.commands[command_].tick <= next;
        for (; command_ < recording_.commands.size() && recording_.commands[command_].tick <= next;
             ++command_)
            track_patient_->command(recording_.commands[command_].tick,
                                    recording_.commands[command_].command);
        if (is_commanded || next >= track_patient_->next_look() || next % carm_every_ticks == 0)
            look_at_track();
        if (next % snapshot_every_ticks == 0) {
            std::vector<std::uint8_t> bytes = device.link().read_snapshot();
            const std::lock_guard lock(mutex_);
            snapshots_[next] = std::move(bytes);
        }
        prepared_ = next;
    }
    return device.link().tick() < ticks();
}

// The patient is injured as in the recorded session.
void ReplayRoom::feel_walls(Device &device)
{
    if (!track_patient_->can_be_injured() || device.link().tick() % Patient::feel_every_ticks != 0) return;
    if (track_patient_->feel(device.link().read_contacts()))
        track_patient_->locate(session_frame(device, track_state_, {}).wire);
}

// Advances the device to the wanted tick for the pictures, either from its present tick or from the nearest
// earlier snapshot. The last tick is always computed, because a snapshot does not contain the readings of the
// tick at which it was taken.
void ReplayRoom::go_to(std::uint32_t tick)
{
    const std::uint32_t now = device_->link().tick();
    const std::uint32_t before = tick > 0 ? tick - 1 : 0;
    const RecordedSnapshot *recorded = recording_.snapshot_before(before);
    std::uint32_t known = recorded ? recorded->tick : 0;
    std::vector<std::uint8_t> own;
    {
        const std::lock_guard lock(mutex_);
        auto after = snapshots_.upper_bound(before);
        if (after != snapshots_.begin() && (--after)->first > known) {
            known = after->first;
            own = after->second;
        }
    }
    if (now > tick || now < known) {
        state_ = {};
        if (!own.empty())
            device_->restore(own);
        else if (recorded)
            device_->restore(recorded->bytes);
        else
            device_ = device_of(recording_, scene_); // the first seconds have no snapshot
    }
    step_to(*device_, tick, state_);
    device_->link().read_nodes();
}

ReplayPicture ReplayRoom::picture(const ReplayAsk &ask)
{
    const std::uint32_t tick = std::min(ask.tick, ticks());
    go_to(tick);
    ReplayPicture result;
    const crn_wire_tick_input input = tick > 0 ? recording_.ticks[tick - 1].input : crn_wire_tick_input{};
    result.frame = session_frame(*device_, state_, input);
    result.state = state_;
    result.is_prepared = tick <= prepared_;
    Moment moment;
    {
        const std::lock_guard lock(mutex_);
        auto after = moments_.upper_bound(tick);
        if (after != moments_.begin()) moment = (--after)->second;
    }
    WireFrame wire = result.frame.wire;
    wire.tick = tick;
    const LineNumbers line = state_.line_count > 0
                                 ? line_of(state_)
                                 : line_or_table(recording_.header.line, recording_.header.tools.size());
    result.line = line;
    std::vector<SweptCurve> curves =
        balloon_filling(wire, tools_on(recording_.header.tools, line), settings_.balloon_iodine_mg_per_ml);
    const std::size_t balloon = curves.size();
    if (moment.curves && result.is_prepared)
        curves.insert(curves.end(), moment.curves->begin(), moment.curves->end());
    PushedVessels(wire).push(std::span(curves).subspan(balloon));
    XraySettings xray;
    xray.carm = result.carm = ask.carm ? *ask.carm : moment.carm;
    xray.size = settings_.size;
    XrayPicture picture;
    const std::vector<RadiopaqueInstrument> looks = looks_on(looks_, line);
    xray_->render(xray, {looks, wire, curves, patient_->bodies_at(wire)}, settings_.seed, nullptr, picture);
    result.size = picture.size;
    result.grey = std::move(picture.grey);
    return result;
}

} // namespace crn
