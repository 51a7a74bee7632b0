// Simulates the patient of a session: vessels with blood and contrast medium, stents, lesions that balloons
// can open, heart and breath, and the applied X-rays with their dose. The program that runs the session (for
// a script, a window, a rig or a replay) advances the patient tick by tick. The program passes the patient's
// commands for the next tick to the core. Pictures, reports and scores read the state and change nothing, so
// a session does not depend on which of them are requested.
//
//   patient.command(tick, {RoomAction::inject, {...}});        in force from that tick on
//   patient.give_orders(input.orders);                        for every tick before it is done
//   patient.tick(input, state);                               for every tick that was done
//   patient.look(shape of the line at that tick);             no later than patient.next_look()
//
// The patient's state depends only on the commands, on the core's inputs and results, and on the tools' shape
// at ticks that the patient chooses.
#pragma once
#include "host/base/state_archive.hpp"
#include "host/effects/pulse.hpp"
#include "host/model/instrument.hpp"
#include "host/model/scene_anatomy.hpp"
#include "host/model/tool_line.hpp"
#include "host/patient/body_poses.hpp"
#include "host/patient/catheter_air.hpp"
#include "host/patient/catheter_pressure.hpp"
#include "host/patient/complications.hpp"
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
    LineNumbers line{};              // tools on the line at the start (tool_line.hpp); empty: all
    // Holds the bodies (closed meshes) for X-ray pictures, which several patients of the same anatomy may
    // share; if the pointer is null, the patient makes them.
    std::shared_ptr<const XrayScene> xray_scene{};
};

class Patient
{
  public:
    // `tools` is the table of the session's tools; settings.line says which are in use at the start. If the
    // anatomy is empty, the patient has no vessels and consists of air. Throws std::runtime_error if a body
    // has an unknown material.
    Patient(const SceneAnatomy &anatomy, const std::vector<Instrument> &tools,
            const PatientSettings &settings = {});
    ~Patient();
    Patient(const Patient &) = delete;
    Patient &operator=(const Patient &) = delete;

    // A command takes effect in its own tick, so call command() before look() for that tick. If a command
    // cannot be carried out now, it is kept in refusals() or stents()->refusals(), and notice() reports it.
    // Throws std::runtime_error if no state of the X-ray room allows the command (unknown action, or a value
    // out of range).
    void command(std::uint32_t tick, const RoomCommand &command);
    // Receives every tick in order, with its input and its result.
    void tick(const crn_wire_tick_input &input, const crn_wire_tick_state &state);
    // Returns the next tick at which look() must be called, or UINT32_MAX if no call is needed.
    std::uint32_t next_look() const;
    // Advances to the frame's tick. In the mode FREE_RUN a rig itself chooses the moments at which it sends
    // the shape of the tools. The picture of an X-ray pulse between two messages with the tools' shape uses
    // the later shape.
    void look(const WireFrame &wire);
    // Updates only the vessels for this frame; a replay that starts later than tick 0 calls this function for
    // every frame before its start.
    std::uint32_t next_vessel_look() const;
    void look_at_vessels(const WireFrame &wire);
    // Returns true if the patient's state depends on every tick since the first. If it does, a replay
    // that starts later than tick 0 must simulate all ticks before its start.
    bool needs_beginning() const { return stents_ != nullptr || can_be_injured(); }

    // Returns true if the vessels may be dissected or perforated. Then feel() must receive the forces of the
    // walls every feel_every_ticks ticks, after the tick to which they belong.
    bool can_be_injured() const;
    static constexpr std::uint32_t feel_every_ticks = 16;
    // Returns true if the frame of this tick must be passed to locate().
    bool feel(const crn_wire_contacts &contacts) { return complications_.feel(contacts); }
    void locate(const WireFrame &wire);

    // --- commands for the core in the next tick; call give_orders() before each tick. A replay does not need
    // them: they are in the recording. ---
    void give_orders(crn_wire_order_list &orders);

    // Saves or restores the whole state of the patient, except the events of the last call of look(). `last`
    // is the result of the session's last tick, and `now` is the number of that tick. An archive from a
    // session with other vessels, stents or tools is refused; the caller must then restore the patient from
    // an archive of this session.
    void archive(StateArchive &state, std::uint32_t now, const crn_wire_tick_state &last);

    // --- state ---
    const Room &room() const { return room_; } // also the room's events at the last look
    const PatientContrast &contrast() const { return contrast_; }
    PatientStents *stents() { return stents_.get(); } // null: the session has no stents
    const PatientStents *stents() const { return stents_.get(); }
    // Returns the traces of the monitor. The monitor shows the pressure at the catheter's tip if a catheter
    // lies in the vessels, and otherwise the aortic pressure.
    const PulseMonitor &monitor() const { return monitor_; }
    const CatheterPressure &catheter_pressure() const { return catheter_pressure_; }
    const PatientComplications &complications() const { return complications_; }
    const CatheterAir &catheter_air() const { return catheter_air_; }
    // Returns the ticks at which medium was injected although the catheter's pressure was damped.
    const std::vector<std::uint32_t> &damped_injections() const { return damped_injections_; }
    const crn_wire_tick_state &state() const { return state_; }     // of the last tick
    const std::vector<Instrument> &table() const { return table_; } // all tools of the session
    // Returns the tools in use after the last tick, one for each position; a position without a tool has an
    // entry without a name.
    const std::vector<Instrument> &tools() const { return tools_; }
    const LineNumbers &line() const { return line_; }
    // Returns the requests for X-ray runs and for injections that the patient refused, in order of their
    // ticks.
    std::vector<Refusal> refusals() const;
    const RoomNotice &notice() const { return notice_; } // the last notice of syringe and stents
    const XrayScene &scene() const { return *scene_; }
    // Returns the bodies that heart, breath and open lesions move, at the moment of this shape. The returned
    // list of bodies is valid until the next call.
    std::span<const MovedBody> bodies_at(const WireFrame &wire) { return poses_.at(wire); }

  private:
    void archive_line(StateArchive &state);
    void follow_line(const crn_wire_tick_state &state);
    void carry_out_due();
    void carry_out(std::uint32_t tick, const RoomCommand &command);
    std::string aspirate(std::uint32_t tick, std::int32_t volume_ul);
    void note_injection(std::uint32_t tick);
    void take_wounds();
    void note_injury(std::uint32_t tick);
    void advance_room(std::uint32_t tick, const WireFrame &wire);

    const std::vector<Instrument> table_;
    LineNumbers line_;
    std::vector<Instrument> tools_; // on the line
    std::shared_ptr<const XrayScene> scene_;
    BodyPoses poses_;
    XrayMeter meter_; // created after the scene has its bodies
    Room room_;
    PatientContrast contrast_;
    CatheterPressure catheter_pressure_;
    PatientComplications complications_;
    CatheterAir catheter_air_;
    std::vector<Refusal> refused_aspirations_;
    std::vector<std::uint32_t> damped_injections_;
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
