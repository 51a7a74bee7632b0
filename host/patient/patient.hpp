// Simulates the patient of a session: vessels with blood and contrast medium, stents, lesions that yield,
// heart and breath, and the applied X-ray with its dose. Whatever runs the session (script, window, rig or
// replay) advances the patient tick by tick, and passes the patient's orders for the next tick to the core.
// Pictures, reports and scores read the state and change nothing, so a session does not depend on which of
// them are requested.
//
//   patient.command(tick, {RoomAction::inject, {...}});        in force from that tick on
//   patient.give_orders(input.orders);                        for every tick before it is done
//   patient.tick(input, state);                               for every tick that was done
//   patient.look(shape of the line at that tick);             no later than patient.next_look()
//
// The state follows only from the commands, from the inputs and results of the core, and from the line's
// shape at ticks that the patient chooses.
#pragma once
#include "host/effects/pulse.hpp"
#include "host/model/instrument.hpp"
#include "host/model/opened_bodies.hpp"
#include "host/model/scene_anatomy.hpp"
#include "host/patient/contrast.hpp"
#include "host/patient/stents.hpp"
#include "host/room/room.hpp"
#include "host/xray/meter.hpp"
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

struct PatientSettings {
    std::string bodies_path;         // for messages only
    std::vector<StentDesign> stents; // stents that a session may load, in this order
    int threads = 2;                 // threads of the measuring chamber
};

class Patient
{
  public:
    // `tools` are given from the innermost out. With an empty anatomy the patient consists of air without
    // vessels. Throws std::runtime_error if a body has an unknown material.
    Patient(const SceneAnatomy &anatomy, const std::vector<Instrument> &tools,
            const PatientSettings &settings = {});
    ~Patient();
    Patient(const Patient &) = delete;
    Patient &operator=(const Patient &) = delete;

    // --- what happens to the patient ---
    // The command is in force from its tick on; call this before the look at that tick. A command that cannot
    // be carried out now is kept in refusals() or stents()->refusals(), and notice() reports it. Throws
    // std::runtime_error for a command that the X-ray room does not have.
    void command(std::uint32_t tick, const RoomCommand &command);
    // Takes every tick in order, with its input and its result.
    void tick(const crn_wire_tick_input &input, const crn_wire_tick_state &state);
    // Returns the next tick at which look() is needed; UINT32_MAX if no look is needed.
    std::uint32_t next_look() const;
    // Advances to the frame's tick. A rig in FREE_RUN sends the line's shape at times of its own. An X-ray
    // pulse between two shapes is made with the later one.
    void look(const WireFrame &wire);
    // Updates only the vessels for this frame; a replay with a later start calls this until its start.
    std::uint32_t next_vessel_look() const;
    void look_at_vessels(const WireFrame &wire);
    // Returns true if the state depends on every tick since the first, so that a replay with a later start
    // must simulate all of them.
    bool needs_beginning() const { return stents_ != nullptr; }

    // --- orders to the core for the next tick; call this function before each tick. A replay does not need
    // them: they are in the recording. ---
    void give_orders(crn_wire_order_list &orders);

    // --- state ---
    const Room &room() const { return room_; } // also the room's events at the last look
    const PatientContrast &contrast() const { return contrast_; }
    PatientStents *stents() { return stents_.get(); } // null: the session has no stents
    const PatientStents *stents() const { return stents_.get(); }
    const PulseMonitor &monitor() const { return monitor_; }
    const crn_wire_tick_state &state() const { return state_; } // of the last tick
    // Returns the requests that were refused, in order of their ticks: runs and injections.
    std::vector<Refusal> refusals() const;
    const RoomNotice &notice() const { return notice_; } // the last notice of syringe and stents
    const XrayScene &scene() const { return scene_; }
    // Returns the bodies that heart, breath and open lesions move, at the moment of this shape. The returned
    // list is valid until the next call.
    std::span<const MovedBody> bodies_at(const WireFrame &wire);

  private:
    void carry_out_due();
    void carry_out(std::uint32_t tick, const RoomCommand &command);
    void advance_room(std::uint32_t tick, const WireFrame &wire);

    XrayScene scene_;
    std::optional<MovingBodies> moving_;
    OpenedBodies opened_;
    std::vector<MovedBody> moved_;
    std::optional<MotionMoment> moved_at_; // moment to which they were last moved
    std::vector<double> moved_open_;
    XrayMeter meter_; // created after the scene has its bodies
    Room room_;
    PatientContrast contrast_;
    std::unique_ptr<PatientStents> stents_;
    PulseMonitor monitor_;
    crn_wire_tick_state state_{};
    struct Asked { // a command to medium or stents, until its tick is over
        std::uint32_t tick;
        RoomCommand command;
    };
    std::deque<Asked> asked_;
    RoomNotice notice_;
    bool has_begun_ = false;
};

} // namespace crn
