// Processes ticks, commands and pulses.
#include "host/room/room.hpp"
#include <algorithm>
#include <cmath>
#include <limits>

namespace crn
{
namespace
{

constexpr std::uint32_t never = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t look_every_ticks = 50; // how often the tip is checked, to follow it
constexpr double follow_zone =
    0.22; // distance of the tip from the middle that is allowed, share of the field's width

// Returns the dose per frame in nGy that reaches the detector behind patient and grid; it is in the middle of
// the usual range (host/xray/xray.hpp).
double frame_dose_nGy(RunKind kind)
{
    return kind == RunKind::fluoro ? 40.0 : kind == RunKind::cine ? 170.0 : 1200.0;
}

ExposureMode exposure_mode(RunKind kind)
{
    return kind == RunKind::fluoro ? ExposureMode::fluoro
           : kind == RunKind::cine ? ExposureMode::cine
                                   : ExposureMode::dsa;
}

GantryPose with_angles(GantryPose pose, const RoomCommand &command)
{
    pose[axis_primary] = command.values[0] * 1e-3;
    pose[axis_secondary] = command.values[1] * 1e-3;
    return pose;
}

GantryPose with_table(GantryPose pose, const Eigen::Vector3d &place_m)
{
    pose[axis_table_x] = place_m.x();
    pose[axis_table_y] = place_m.y();
    pose[axis_table_z] = place_m.z();
    return pose;
}

GantryPose with_distances(GantryPose pose, const RoomCommand &command)
{
    pose[axis_sid] = command.values[0] * 1e-6;
    pose[axis_sod] = command.values[1] * 1e-6;
    return pose;
}

} // namespace

// --- time ---

std::uint32_t Room::Beam::next_tick() const
{
    return tick_begin + static_cast<std::uint32_t>((std::int64_t{index} * 100'000 + rate_centihertz - 1) /
                                                   rate_centihertz);
}

std::string Room::give(std::uint32_t tick, const RoomCommand &command)
{
    const std::string why = refusal(command);
    if (!why.empty()) return why;
    const std::int64_t first = std::max<std::int64_t>(tick_ + 1, queue_.empty() ? 0 : queue_.back().tick);
    queue_.push_back({static_cast<std::uint32_t>(std::max<std::int64_t>(tick, first)), command});
    return "";
}

std::uint32_t Room::next_tick() const
{
    std::uint32_t next = queue_.empty() ? never : queue_.front().tick;
    if (beam_.is_on) next = std::min(next, beam_.next_tick());
    if (follows_tip_)
        next = std::min(next, static_cast<std::uint32_t>((tick_ / look_every_ticks + 1) * look_every_ticks));
    return next;
}

void Room::advance(std::uint32_t tick, const Eigen::Vector3d *tip)
{
    while (tick_ < std::int64_t{tick}) {
        const auto next = static_cast<std::uint32_t>(tick_ + 1);
        process(next, next == tick ? tip : nullptr);
    }
}

// Processes one millisecond: first the commands, then the motors, and finally the pedals and X-ray pulses.
void Room::process(std::uint32_t tick, const Eigen::Vector3d *tip)
{
    tick_ = tick;
    while (!queue_.empty() && queue_.front().tick <= tick) {
        const RoomCommand command = queue_.front().command;
        queue_.pop_front();
        carry_out(tick, command);
    }
    if (follows_tip_ && tip && tick % look_every_ticks == 0 && !is_acquire_waiting_) follow(tick, *tip);
    // During a run of digital subtraction angiography (DSA) the table does not move, because the patient must
    // not move between mask and frame.
    if (!(beam_.is_on && beam_.kind == RunKind::dsa)) gantry_.tick();
    if (gantry_.is_blocked() && !was_blocked_) notify(tick, "TABLE IN THE WAY - motion stopped");
    was_blocked_ = gantry_.is_blocked();
    press_pedals(tick);
    is_pulse_due_ = beam_.is_on && tick == beam_.next_tick();
    while (beam_.is_on && beam_.next_tick() <= tick) ++beam_.index;
    if (!beam_.is_on) return;
    const std::uint32_t reminders = dose_.fluoro_reminders();
    dose_.pass_tick();
    if (dose_.fluoro_reminders() > reminders)
        notify(tick, "FLUOROSCOPY " + std::to_string(dose_.fluoro_ticks() / 60'000) + " MIN");
}

void Room::notify(std::uint32_t tick, const std::string &text)
{
    notice_ = {text, tick};
}

// --- commands ---

void Room::carry_out(std::uint32_t tick, const RoomCommand &command)
{
    tell(RoomEvent::Kind::command, tick).command = command;
    const std::int32_t value = command.values[0];
    switch (command.action) {
    case RoomAction::fluoro_pedal:
        is_fluoro_armed_ = value == 1 && (is_fluoro_armed_ || !is_fluoro_down_);
        is_fluoro_down_ = value == 1;
        if (beam_.is_on && !beam_.is_acquired && !is_fluoro_down_) end_beam(tick);
        break;
    case RoomAction::acquire_pedal:
        if (value == 1) refuse_second_run(tick);
        if (value == 0) release_acquisition(tick);
        is_acquire_armed_ = value == 1 && (is_acquire_armed_ || !is_acquire_down_);
        is_acquire_down_ = value == 1;
        if (beam_.is_on && beam_.is_acquired && !is_acquire_down_) end_beam(tick);
        break;
    case RoomAction::program:
        program_ = value == 1 ? RunKind::dsa : RunKind::cine;
        break;
    case RoomAction::fluoro_rate:
        fluoro_centihertz_ = value;
        break;
    case RoomAction::cine_rate:
        cine_centihertz_ = value;
        break;
    case RoomAction::dsa_rate:
        dsa_centihertz_ = value;
        break;
    case RoomAction::store:
        store_fluoro(tick, static_cast<std::uint32_t>(value));
        break;
    case RoomAction::acknowledge:
        dose_.acknowledge();
        break;
    case RoomAction::mask: // for the screen
    case RoomAction::shift:
    case RoomAction::roadmap:
    case RoomAction::review:
    case RoomAction::inject: // for the syringe
    case RoomAction::contrast_strength:
    case RoomAction::aspirate:
    case RoomAction::load_stent: // for the stents
    case RoomAction::complications:
    case RoomAction::complication_limit: // for the vessels
        break;
    default:
        carry_out_geometry(tick, command);
    }
}

void Room::carry_out_geometry(std::uint32_t tick, const RoomCommand &command)
{
    const std::int32_t *values = command.values;
    switch (command.action) {
    case RoomAction::angles:
        return move(tick, with_angles(gantry_.target(), command));
    case RoomAction::distance:
        return move(tick, with_distances(gantry_.target(), command));
    case RoomAction::table:
        follows_tip_ = false;
        return move(tick,
                    with_table(gantry_.target(), Eigen::Vector3d(values[0], values[1], values[2]) * 1e-6));
    case RoomAction::follow:
        follows_tip_ = values[0] == 1;
        break;
    case RoomAction::field:
        field_um_ = values[0];
        break;
    case RoomAction::blades:
        blade_width_permille_ = values[0];
        blade_height_permille_ = values[1];
        break;
    case RoomAction::iris:
        is_round_ = values[0] == 1;
        break;
    default: // halt
        follows_tip_ = false;
        gantry_.halt();
    }
}

// At the first tick the room is set up: an order at that tick moves C-arm and table to their pose at once,
// without motion.
void Room::move(std::uint32_t tick, const GantryPose &pose)
{
    if (tick > 0) return gantry_.aim(pose);
    gantry_.place(pose);
    if (table_clearance_m(gantry_.pose()) < Gantry::clearance_min_m)
        notify(tick, "THE TABLE IS IN THE WAY HERE - only ways out are free");
}

// Moves the table as a person would do, so that the X-ray field follows the tip of the tools: the table rests
// while the tip is well inside the field. When the tip comes near the edge of the field, the table brings the
// tip back to the middle.
void Room::follow(std::uint32_t tick, const Eigen::Vector3d &tip)
{
    if (tick == 0) return move(tick, with_table(gantry_.target(), tip));
    const View view = make_view(gantry_.carm(field_m()), 512);
    Eigen::Vector2d pixel;
    const bool is_in_front = project(view, tip, pixel);
    const double zone = follow_zone * view.size, middle = 0.5 * view.size;
    const bool is_inside =
        is_in_front && std::fabs(pixel.x() - middle) <= zone && std::fabs(pixel.y() - middle) <= zone;
    if (!is_inside || gantry_.is_moving()) {
        const GantryPose wanted = with_table(gantry_.target(), tip);
        if (wanted != gantry_.target() && !gantry_.is_blocked()) gantry_.aim(wanted);
    }
}

// --- pedals ---

// Only a new press of the pedal begins a run. A pedal that was still pressed when another run ended does
// nothing until the user releases and presses it again.
void Room::press_pedals(std::uint32_t tick)
{
    if (beam_.is_on && beam_.is_acquired) return;
    // All frames of a run must have the same geometry, so the run does not begin before the motors of C-arm
    // and table are at rest. Fluoroscopy continues meanwhile.
    const bool waits = is_acquire_armed_ && gantry_.is_moving();
    if (waits && !is_acquire_waiting_)
        notify(tick, name_of_program() + " WAITS - the C-arm or the table is moving");
    is_acquire_waiting_ = waits;
    if (is_acquire_armed_ && !waits) {
        if (beam_.is_on) end_beam(tick); // the acquisition pedal overrules fluoroscopy
        begin_beam(tick, true);
    } else if (!beam_.is_on && is_fluoro_armed_) {
        begin_beam(tick, false);
    }
}

// If the user released the pedal before the run began, no run is made, and the user must be informed.
void Room::release_acquisition(std::uint32_t tick)
{
    if (is_acquire_waiting_)
        refuse(tick, no_run() + "the pedal went up while the C-arm or the table was still moving",
               "wait until it stands, or hold the pedal longer");
    else if (is_acquire_armed_)
        refuse(tick, no_run() + "the pedal went up at the moment at which it went down",
               "hold the pedal while the run lasts");
    is_acquire_waiting_ = is_acquire_armed_ = false;
}

// A pedal that is down cannot be pressed. The run of another program needs a new press.
void Room::refuse_second_run(std::uint32_t tick)
{
    if (!is_acquire_down_ || !beam_.is_on || !beam_.is_acquired || beam_.kind == program_) return;
    refuse(tick, no_run() + "the pedal is still down for another run",
           "release it first, then press it again");
}

void Room::refuse(std::uint32_t tick, const std::string &why, const std::string &remedy)
{
    notify(tick, why);
    refusals_.push_back({tick, why + "; " + remedy});
}

// A run that waits for the motors while the session ends was never made.
std::vector<Refusal> Room::refusals() const
{
    std::vector<Refusal> all = refusals_;
    const bool is_ordered = std::any_of(queue_.begin(), queue_.end(), [](const Queued &queued) {
        return queued.command.action == RoomAction::acquire_pedal && queued.command.values[0] == 1;
    });
    const auto tick = static_cast<std::uint32_t>(std::max<std::int64_t>(tick_, 0));
    if (is_acquire_waiting_)
        all.push_back({tick, no_run() + "the session ended while the C-arm or the table was still moving; "
                                        "let it stand, then press the pedal"});
    else if (is_acquire_armed_ || is_ordered)
        all.push_back({tick, "NO RUN - the session ended at the moment at which the pedal went down; "
                             "hold the pedal while the run lasts"});
    return all;
}

void Room::begin_beam(std::uint32_t tick, bool is_acquired)
{
    is_fluoro_armed_ = is_acquire_armed_ = false;
    beam_ = {true, is_acquired ? program_ : RunKind::fluoro, is_acquired, tick, fluoro_centihertz_, 0, {}};
    if (beam_.kind == RunKind::cine) beam_.rate_centihertz = cine_centihertz_;
    if (beam_.kind == RunKind::dsa) beam_.rate_centihertz = dsa_centihertz_;
    Irradiation irradiation;
    irradiation.kind = beam_.kind;
    irradiation.tick_begin = irradiation.tick_end = tick;
    irradiation.pulses_per_s = static_cast<double>(beam_.rate_centihertz) * 0.01;
    irradiation.carm = gantry_.carm(field_m());
    dose_.begin(irradiation);
    is_run_made_ = false;
    RoomEvent &event = tell(RoomEvent::Kind::beam_on, tick);
    event.run_kind = beam_.kind;
    event.pulses_per_s = irradiation.pulses_per_s;
    event.run = is_acquired ? static_cast<int>(runs_.size()) + 1 : 0;
    event.carm = irradiation.carm;
}

void Room::end_beam(std::uint32_t tick)
{
    beam_.is_on = false;
    is_pulse_due_ = false;
    const int kept = beam_.is_acquired && is_run_made_ ? runs_.back().number : 0;
    dose_.end(tick, kept);
    tell(RoomEvent::Kind::beam_off, tick).run = kept;
}

// The run is entered in the list of runs together with its first frame. Returns its number.
int Room::count_frame(double pulses_per_s)
{
    if (is_run_made_)
        ++runs_.back().frames;
    else
        keep_run(beam_.kind, pulses_per_s, 1);
    is_run_made_ = true;
    return runs_.back().number;
}

int Room::keep_run(RunKind kind, double pulses_per_s, std::uint32_t frames)
{
    const int number = static_cast<int>(runs_.size()) + 1;
    runs_.push_back({number, kind, pulses_per_s, frames});
    return number;
}

void Room::store_fluoro(std::uint32_t tick, std::uint32_t milliseconds)
{
    if (beam_.is_on) return notify(tick, "RELEASE THE PEDAL, then store fluoroscopy");
    std::uint32_t frames = 0;
    for (const std::uint32_t passed : passed_) frames += tick - passed < milliseconds;
    if (frames == 0) return notify(tick, "NO FLUOROSCOPY TO STORE in this time");
    RoomEvent &event = tell(RoomEvent::Kind::fluoro_kept, tick);
    event.run = keep_run(RunKind::fluoro, passed_pulses_per_s_, frames);
    event.milliseconds = milliseconds;
    notify(tick, "Fluoroscopy stored as run " + std::to_string(event.run));
}

RoomEvent &Room::tell(RoomEvent::Kind kind, std::uint32_t tick)
{
    events_.emplace_back();
    events_.back().kind = kind;
    events_.back().tick = tick;
    return events_.back();
}

// --- pulses ---

PulseRequest Room::pulse() const
{
    PulseRequest request;
    request.kind = beam_.kind;
    request.carm = gantry_.carm(field_m());
    request.beam.mode = exposure_mode(beam_.kind);
    request.beam.dose_per_frame_nGy = frame_dose_nGy(beam_.kind);
    request.beam.frame_period_ms = 1e5 / static_cast<double>(beam_.rate_centihertz);
    request.beam.fixed_technique = beam_.locked;
    request.settles_at_once = beam_.kind == RunKind::dsa && !beam_.locked;
    request.beam.circular_field = is_round_;
    request.beam.open_width_share = blade_width_permille_ * 1e-3;
    request.beam.open_height_share = blade_height_permille_ * 1e-3;
    return request;
}

void Room::expose(const XrayExposure &exposure)
{
    if (!is_pulse_due_) return;
    const auto tick = static_cast<std::uint32_t>(tick_);
    RoomEvent &event = tell(RoomEvent::Kind::pulse, tick);
    event.request = pulse();
    event.exposure = exposure;
    event.press = dose_.irradiations().size() - 1;
    event.run_kind = beam_.kind;
    event.pulses_per_s = static_cast<double>(beam_.rate_centihertz) * 0.01;
    if (beam_.is_acquired) event.run = count_frame(event.pulses_per_s);
    is_pulse_due_ = false;
    if (beam_.kind == RunKind::dsa) beam_.locked = exposure.technique;
    technique_ = exposure.technique;
    is_underexposed_ = exposure.is_underexposed;
    dose_.note_pulse(event.request.carm, technique_.tube_voltage_kV, technique_.tube_current_mA,
                     technique_.pulse_ms);
    dose_.add(tick, exposure.air_kerma_uGy, exposure.kap_Gy_cm2);
    if (beam_.is_acquired) return;
    passed_pulses_per_s_ = event.pulses_per_s;
    passed_.push_back(tick);
    while (tick - passed_.front() >= static_cast<std::uint32_t>(store_max_ms)) passed_.pop_front();
}

RoomState Room::state() const
{
    RoomState state;
    state.tick = static_cast<std::uint32_t>(std::max<std::int64_t>(tick_, 0));
    state.carm = gantry_.carm(field_m());
    state.is_moving = gantry_.is_moving();
    state.is_blocked = gantry_.is_blocked();
    state.follows_tip = follows_tip_;
    state.is_beam_on = beam_.is_on;
    state.program = program_;
    state.fluoro_pulses_per_s = fluoro_centihertz_ * 0.01;
    state.program_pulses_per_s = (program_ == RunKind::dsa ? dsa_centihertz_ : cine_centihertz_) * 0.01;
    state.open_width_share = blade_width_permille_ * 1e-3;
    state.open_height_share = blade_height_permille_ * 1e-3;
    state.is_round = is_round_;
    state.technique = technique_;
    state.is_underexposed = is_underexposed_;
    if (notice_.is_shown_at(tick_)) state.notice = notice_.text;
    return state;
}

} // namespace crn
