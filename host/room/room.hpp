// The X-ray room as a state machine: pedals, geometry, pulses, runs by number, dose. No window, no clock, no
// X-ray and no pictures of its own: commands and ticks go in, requests for pulses and what happened come out.
//
//   room.give(tick, command);                    // in force from that tick on, before it is carried out
//   room.advance(tick, &tip);                    // every millisecond up to `tick`
//   if (room.is_pulse_due()) room.expose(meter.expose(..., room.pulse(), ...));
//   for (const RoomEvent &event : room.events()) ...      // for whoever makes pictures of it: room_screen.hpp
//   room.forget_events();
//
// Stop at next_tick() at the latest, or pulses are missed. The same commands and bodies give the same pulses
// and the same dose, whoever looks. See docs/room.md.
#pragma once
#include "host/room/command.hpp"
#include "host/room/dose.hpp"
#include "host/room/gantry.hpp"
#include "host/xray/meter.hpp"
#include "host/xray/run.hpp"
#include "host/xray/xray.hpp"
#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

struct PulseRequest {
    RunKind kind = RunKind::fluoro;
    CArm carm;
    XrayBeam beam;
    bool settles_at_once = false; // a test exposure has found the technique: render without generator memory
};

// Something that the room did, in the order in which it happened.
struct RoomEvent {
    enum class Kind { command, beam_on, pulse, beam_off, fluoro_kept };
    Kind kind = Kind::command;
    std::uint32_t tick = 0;
    RoomCommand command;                // of command: it is being carried out
    RunKind run_kind = RunKind::fluoro; // of beam_on and pulse
    double pulses_per_s = 0.0;          // the same
    int run = 0;                        // number of the run that begins, has a pulse, was made; 0: none
    std::uint32_t milliseconds = 0;     // of fluoro_kept: how far back
    CArm carm;                          // of beam_on
    std::size_t press = 0;              // of pulse: which irradiation of the dose meter it belongs to, from 0
    PulseRequest request;               // of pulse
    XrayExposure exposure;              // of pulse
};

// A run that was made, as the room counts it. Its pictures, if somebody makes them, are the screen's.
struct RoomRun {
    int number = 0;
    RunKind kind = RunKind::fluoro;
    double pulses_per_s = 0.0;
    std::uint32_t frames = 0;
};

// What the display tells about the room itself.
struct RoomState {
    std::uint32_t tick = 0;
    CArm carm;
    bool is_moving = false, is_blocked = false, follows_tip = false;
    bool is_beam_on = false;
    RunKind program = RunKind::cine;                              // what the acquisition pedal makes
    double fluoro_pulses_per_s = 0.0, program_pulses_per_s = 0.0; // chosen for the next press
    double open_width_share = 1.0, open_height_share = 1.0;
    bool is_round = false;
    XrayTechnique technique; // of the last pulse
    bool is_underexposed = false;
    std::string notice; // of the last four seconds
};

// A sentence on the screen, for four seconds.
struct RoomNotice {
    std::string text;
    std::int64_t from = -1; // tick
    bool is_shown_at(std::int64_t tick) const { return from >= 0 && tick < from + 4000; }
};

class Room
{
  public:
    // Commands come in the order of their ticks; one of a tick already passed counts for the next. Returns
    // why a command cannot be carried out at all, else empty.
    std::string give(std::uint32_t tick, const RoomCommand &command);
    // The next tick at which something is to be seen: a command, a pulse, or a look at the tip. UINT32_MAX:
    // none.
    std::uint32_t next_tick() const;
    // `tip`: where the leading tip is at `tick`; nullptr: not known.
    void advance(std::uint32_t tick, const Eigen::Vector3d *tip);

    bool is_pulse_due() const { return is_pulse_due_; }
    PulseRequest pulse() const;
    // What pulse() was taken with: counted from now on.
    void expose(const XrayExposure &exposure);

    // What happened since forget_events().
    const std::vector<RoomEvent> &events() const { return events_; }
    void forget_events() { events_.clear(); }

    RoomState state() const;
    const RoomNotice &notice() const { return notice_; }
    const Gantry &gantry() const { return gantry_; }
    const DoseMeter &dose() const { return dose_; }
    const std::vector<RoomRun> &runs() const { return runs_; }
    // Presses of a pedal that made no run.
    const std::vector<Refusal> &refusals() const { return refusals_; }
    bool is_beam_on() const { return beam_.is_on; }
    double field_m() const { return field_um_ * 1e-6; }
    std::int64_t tick() const { return tick_; } // the last one that is over; -1: none

  private:
    struct Queued { // a command that waits for its tick
        std::uint32_t tick;
        RoomCommand command;
    };
    struct Beam {
        bool is_on = false;
        RunKind kind = RunKind::fluoro;
        bool is_acquired = false;
        std::uint32_t tick_begin = 0;
        std::int64_t rate_centihertz = 0;
        std::uint32_t index = 0;             // of the next pulse
        std::optional<XrayTechnique> locked; // DSA: what the first frame was taken with
        std::uint32_t next_tick() const;
    };
    void process(std::uint32_t tick, const Eigen::Vector3d *tip);
    void carry_out(std::uint32_t tick, const RoomCommand &command);
    void carry_out_geometry(std::uint32_t tick, const RoomCommand &command);
    void move(std::uint32_t tick, const GantryPose &pose);
    void follow(std::uint32_t tick, const Eigen::Vector3d &tip);
    void press_pedals(std::uint32_t tick);
    void begin_beam(std::uint32_t tick, bool is_acquired);
    void end_beam(std::uint32_t tick);
    void store_fluoro(std::uint32_t tick, std::uint32_t milliseconds);
    void notify(std::uint32_t tick, const std::string &text);
    void release_acquisition(std::uint32_t tick);
    std::string name_of_program() const { return program_ == RunKind::dsa ? "DSA" : "CINE"; }
    RoomEvent &tell(RoomEvent::Kind kind, std::uint32_t tick);
    int count_frame(double pulses_per_s);
    int keep_run(RunKind kind, double pulses_per_s, std::uint32_t frames);

    Gantry gantry_;
    DoseMeter dose_;
    std::vector<RoomRun> runs_;
    std::vector<RoomEvent> events_;
    std::deque<Queued> queue_;
    std::int64_t tick_ = -1; // last one processed
    std::int32_t field_um_ = 320'000;
    std::int32_t blade_width_permille_ = 970, blade_height_permille_ = 970;
    bool is_round_ = false;
    bool follows_tip_ = false, was_blocked_ = false;
    bool is_fluoro_down_ = false, is_fluoro_armed_ = false, is_acquire_down_ = false,
         is_acquire_armed_ = false;
    RunKind program_ = RunKind::cine;
    std::int32_t fluoro_centihertz_ = 1500, cine_centihertz_ = 1500, dsa_centihertz_ = 300;
    Beam beam_;
    bool is_pulse_due_ = false;
    bool is_run_made_ = false;         // of the run that is being acquired
    std::deque<std::uint32_t> passed_; // ticks of fluoroscopy that can still be kept
    double passed_pulses_per_s_ = 0.0;
    XrayTechnique technique_;
    bool is_underexposed_ = false;
    RoomNotice notice_;
    bool is_acquire_waiting_ = false; // for the motors
    std::vector<Refusal> refusals_;
};

} // namespace crn
