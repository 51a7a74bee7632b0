// Runs a session on a device and its patient. Either a script moves the tools in LOCKSTEP, as fast as the
// machine allows, or the hands at a rig move them in FREE_RUN. Meanwhile the session is recorded, and its
// pictures are made.
#pragma once
#include "host/patient/patient.hpp"
#include "host/script/session.hpp"
#include "host/session/contact_figures.hpp"
#include "host/session/device.hpp"
#include "host/session/frame_sink.hpp"
#include "host/session/hand_grip.hpp"
#include <nlohmann/json_fwd.hpp>

namespace crn
{

struct RunSettings {
    bool shows_progress = false;      // one line on stderr, rewritten
    std::vector<RoomCommand> begin{}; // for a script's session, before its first statement
    const TipPlaces *tips = nullptr;  // finds the places of tips, for a script that steers and for the report
    const SessionWitness *witness = nullptr; // for other expectations of a script
};

struct RunResult {
    SessionFigures figures;
    ContactFigures contacts;
    std::uint64_t hash = 0;
    double seconds = 0.0;         // wall clock of the ticks, pictures and recording, without set-up
    bool was_interrupted = false; // Ctrl-C: everything up to that tick is valid
    std::vector<int> given_up_lines;
    std::vector<GripFigures> grips; // of a script's hands, one per tool
    std::vector<SteeringResult> steered;
    std::vector<ExpectationResult> expected;
    std::vector<std::string> failures; // the script's goals that were not reached and expectations that did
                                       // not hold
    std::vector<TipPlace> tips;        // at the end, from the innermost tool; empty: not known
    std::uint32_t resumes = 0;         // number of times that the device disappeared and came back
    std::string stopped_by;            // FREE_RUN: why the device stopped
    std::uint32_t late_ticks = 0, powered_ticks = 0, pictures = 0; // FREE_RUN
    crn_wire_fault_log faults{};
};

// In a FREE_RUN session, this function sends the commands of the simulated patient to the core. Every call of
// this function sends the commands of one tick, because a device can store only a few commands. If the device
// did not carry out a command, the patient repeats the command later. A device that has gone, or has stopped
// by a fault, gets nothing: the next request finds out. Throws LinkError if the device refuses a command.
void send_orders(Link &link, Patient &patient);
void send_orders(Link &link, const crn_wire_order_list &orders);

// `recorder` and `sink` may be nullptr. Throws LinkError, RecordingError.
RunResult run_session(SteppedDevice &device, Patient &patient, const Session &session, Recorder *recorder,
                      FrameSink *sink, const RunSettings &settings);

// Runs a session in FREE_RUN for `seconds`, on the device's own clock. If `seconds` is 0, the session runs
// until the user presses Ctrl-C, which ends it properly. The first button of the rig is the X-ray pedal, and
// the second is the cine pedal. `begin` lists the commands that the X-ray room receives at the start. If the
// rig stops, the session ends, and `stopped_by` gives the reason. All results up to the tick at which the rig
// stopped are valid.
RunResult run_free_session(Device &device, Patient &patient, const std::vector<RoomCommand> &begin,
                           double seconds, Recorder *recorder, FrameSink *sink, const RunSettings &settings);

// Returns the report of a session. The values in the report do not depend on the machine, or on which other
// outputs are requested.
nlohmann::ordered_json report_of(const RunResult &result, const std::string &scene,
                                 const std::vector<Instrument> &tools, const std::string &session,
                                 Patient &patient);
// Returns the computing time of the session on this machine, which differs from run to run.
nlohmann::ordered_json timing_of(const RunResult &result, const Patient &patient);
// Returns the text of a report; write_report() writes it to a file. `report` comes from report_of() or
// timing_of(). write_report() throws OutputError.
std::string report_text(const nlohmann::ordered_json &report);
void write_report(const std::string &path, const nlohmann::ordered_json &report);

} // namespace crn
