// Carry out a session on a device: a script in LOCKSTEP, as fast as the machine allows, or what hands do at a rig in FREE_RUN; recorded
// and pictured on the way.
// May include: device, session, recording, frame_sink. Called by: cli.
#pragma once
#include "host/app/contact_figures.hpp"
#include "host/app/device.hpp"
#include "host/app/frame_sink.hpp"
#include "host/app/hand_grip.hpp"
#include "host/app/session.hpp"
#include "host/room/room.hpp"
#include <nlohmann/json_fwd.hpp>

namespace crn
{

struct RunSettings {
    bool shows_progress = false;             // one line on stderr, rewritten
    std::vector<RoomCommand> begin{};        // of a script's session, before its first statement
    bool measures_contacts = false;          // of a script's session: RunResult::contacts
    const TipPlaces *tips = nullptr;         // where tips are: of a script that steers, and for the report
    const SessionWitness *witness = nullptr; // of what a script expects besides
};

struct RunResult {
    SessionFigures figures;
    ContactFigures contacts;
    std::uint64_t hash = 0;
    double seconds = 0.0;         // wall clock of the ticks, pictures and recording, without set-up
    bool was_interrupted = false; // Ctrl-C: everything up to there is valid
    std::vector<int> given_up_lines;
    std::vector<GripFigures> grips; // of a script's hands, one per tool
    std::vector<SteeringResult> steered;
    std::vector<ExpectationResult> expected;
    std::vector<std::string> failures; // of the script: what was not reached or did not hold
    std::vector<TipPlace> tips;        // at the end, from the innermost tool; empty: not known
    std::uint32_t resumes = 0;         // how often the device went and came back
    std::string stopped_by;            // FREE_RUN: why the device stopped
    std::uint32_t late_ticks = 0, powered_ticks = 0, pictures = 0; // FREE_RUN
    crn_wire_fault_log faults{};
};

// The input of a tick with what the sink wants the core to know, if anything. `sink` may be nullptr.
crn_wire_encoders with_order(crn_wire_encoders input, FrameSink *sink);
// The same in FREE_RUN: one message a round, because a device keeps few. What it does not take up is asked for again at the next look.
void send_order(Link &link, FrameSink &sink);

// `recorder` and `sink` may be nullptr. Throws LinkError, RecordingError.
RunResult run_session(Device &device, const Session &session, Recorder *recorder, FrameSink *sink,
                      const RunSettings &settings);

// FREE_RUN: `seconds` of a session that the device leads, 0: until Ctrl-C, which ends it properly. The rig's first button is the
// X-ray pedal, its second the cine pedal. `begin`: what the room is asked for at the start. A rig that stops ends it: `stopped_by` says why, and everything up to there is valid.
RunResult run_free_session(Device &device, const std::vector<RoomCommand> &begin, double seconds,
                           Recorder *recorder, FrameSink *sink, const RunSettings &settings);

class SessionContrast;
class SessionStents;

// Who knows more of a session; null: nobody. Room (dose and runs) and contrast are there where pictures are made.
struct ReportSources {
    const Room *room = nullptr;
    const SessionContrast *contrast = nullptr;
    SessionStents *stents = nullptr;
    std::vector<Refusal> refusals{}; // runs and injections
};

// The figures of a session, and as a file.
nlohmann::ordered_json report_of(const RunResult &result, const std::string &scene,
                                 const std::vector<Instrument> &tools, const std::string &session,
                                 const ReportSources &sources);
void write_report(const std::string &path, const nlohmann::ordered_json &report);

} // namespace crn
