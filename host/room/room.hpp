// Simulates the X-ray room as a state machine: pedals, geometry, pulses, numbered runs, and dose. The class
// Room contains no window, no clock, no X-ray computation and no pictures. The class Room receives commands
// and ticks, and returns events and requests for X-ray pulses.
//
//   room.give(tick, command);                    // before that tick is processed; in force from then on
//   room.advance(tick, &tip);                    // every millisecond up to `tick`
//   if (room.is_pulse_due()) room.expose(meter.expose(..., room.pulse(), ...));
//   for (const RoomEvent &event : room.events()) ...      // for whatever makes pictures of it: room_screen.hpp
//   room.forget_events();
//
// The caller must not advance beyond next_tick() in one call, because otherwise X-ray pulses are missed.
// Equal commands to the room and equal bodies in the beam give equal X-ray pulses and equal doses, whether or
// not pictures are made. See docs/room.md.
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
    bool settles_at_once = false; // test exposures have found the technique: render without generator memory
};

// Describes something that happened in the room; events are in order of time.
struct RoomEvent {
    enum class Kind { command, beam_on, pulse, beam_off, fluoro_kept };
    Kind kind = Kind::command;
    std::uint32_t tick = 0;
    RoomCommand command;                // for command: the command that is being carried out
    RunKind run_kind = RunKind::fluoro; // for beam_on and pulse
    double pulses_per_s = 0.0;          // for beam_on and pulse
    int run = 0;                        // number of the run that begins, has a pulse, or was made; 0: none
    std::uint32_t milliseconds = 0;     // for fluoro_kept: how far back
    CArm carm;                          // for beam_on
    std::size_t press = 0; // for pulse: the irradiation of the dose meter to which it belongs, from 0
    PulseRequest request;  // for pulse
    XrayExposure exposure; // for pulse
};

// Describes a finished run, which is a series of X-ray pictures, as the room records it. The class RoomScreen
// keeps the pictures of a run, if pictures are made at all.
struct RoomRun {
    int number = 0;
    RunKind kind = RunKind::fluoro;
    double pulses_per_s = 0.0;
    std::uint32_t frames = 0;
};

// Holds the state of the room that the display shows.
struct RoomState {
    std::uint32_t tick = 0;
    CArm carm;
    bool is_moving = false, is_blocked = false, follows_tip = false;
    bool is_beam_on = false;
    RunKind program = RunKind::cine;                              // what the acquisition pedal acquires
    double fluoro_pulses_per_s = 0.0, program_pulses_per_s = 0.0; // selected for the next press
    double open_width_share = 1.0, open_height_share = 1.0;
    bool is_round = false;
    XrayTechnique technique; // of the last pulse
    bool is_underexposed = false;
    std::string notice; // notice of the last four seconds
};

// Holds a sentence that the screen shows for four seconds.
struct RoomNotice {
    std::string text;
    std::int64_t from = -1; // tick of its appearance
    bool is_shown_at(std::int64_t tick) const { return from >= 0 && tick < from + 4000; }
};

class Room
{
  public:
    // The caller must give commands in the order of their ticks. A command for a tick that has already been
    // processed takes effect at the next tick. Returns the reason why no state of the room allows a command,
    // or an empty string if some state allows it.
    std::string give(std::uint32_t tick, const RoomCommand &command);
    // Returns the next tick at which the room must process a command, a pulse, or a check of the tip.
    // UINT32_MAX: none.
    std::uint32_t next_tick() const;
    // `tip` is the position of the leading tip at `tick`; if it is nullptr, the position is not known.
    void advance(std::uint32_t tick, const Eigen::Vector3d *tip);

    bool is_pulse_due() const { return is_pulse_due_; }
    PulseRequest pulse() const;
    // Passes to the room the exposure of the pulse that pulse() requested; the room adds the pulse to its
    // dose.
    void expose(const XrayExposure &exposure);

    // Returns the events since forget_events().
    const std::vector<RoomEvent> &events() const { return events_; }
    void forget_events() { events_.clear(); }

    RoomState state() const;
    const RoomNotice &notice() const { return notice_; }
    const Gantry &gantry() const { return gantry_; }
    const DoseMeter &dose() const { return dose_; }
    const std::vector<RoomRun> &runs() const { return runs_; }
    // Returns the presses of a pedal that did not start a run, with the reasons, as if the session ended now:
    // a run that still waits for the motors is among them.
    std::vector<Refusal> refusals() const;
    bool is_beam_on() const { return beam_.is_on; }
    double field_m() const { return field_um_ * 1e-6; }
    std::int64_t tick() const { return tick_; } // the last processed tick; -1: none

    // Saves or restores the state of the X-ray room at tick `now`, without the last events.
    void archive(StateArchive &state, std::uint32_t now);

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
        std::uint32_t index = 0;             // index of the next pulse
        std::optional<XrayTechnique> locked; // DSA: the technique of the first frame
        std::uint32_t next_tick() const;
    };
    void archive_beam(StateArchive &state);
    void archive_settings(StateArchive &state);
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
    void refuse_second_run(std::uint32_t tick);
    void refuse(std::uint32_t tick, const std::string &why, const std::string &remedy);
    std::string name_of_program() const { return program_ == RunKind::dsa ? "DSA" : "CINE"; }
    std::string no_run() const { return "NO " + name_of_program() + " RUN - "; }
    RoomEvent &tell(RoomEvent::Kind kind, std::uint32_t tick);
    int count_frame(double pulses_per_s);
    int keep_run(RunKind kind, double pulses_per_s, std::uint32_t frames);

    Gantry gantry_;
    DoseMeter dose_;
    std::vector<RoomRun> runs_;
    std::vector<RoomEvent> events_;
    std::deque<Queued> queue_;
    std::int64_t tick_ = -1; // last processed tick
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
    bool is_run_made_ = false;         // for the run being acquired
    std::deque<std::uint32_t> passed_; // ticks of fluoroscopy that can still be kept as a run
    double passed_pulses_per_s_ = 0.0;
    XrayTechnique technique_;
    bool is_underexposed_ = false;
    RoomNotice notice_;
    bool is_acquire_waiting_ = false; // waits for the motors
    std::vector<Refusal> refusals_;
};

} // namespace crn
