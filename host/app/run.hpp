// Carry out a session script on a device in LOCKSTEP: as fast as the machine allows, recorded and pictured on the way.
// May include: device, session, recording, frame_sink. Called by: cli.
#pragma once
#include "host/app/device.hpp"
#include "host/app/frame_sink.hpp"
#include "host/app/session.hpp"

namespace seld
{

struct RunSettings {
    std::uint32_t pictures_per_second = 15;
    bool shows_progress = false; // one line on stderr, rewritten
};

struct RunResult {
    SessionFigures figures;
    std::uint64_t hash = 0;
    double seconds = 0.0;         // wall clock of the ticks, pictures and recording, without set-up
    bool was_interrupted = false; // Ctrl-C: everything up to there is valid
    std::vector<int> given_up_lines;
    std::uint32_t resumes = 0; // how often the device went and came back
    seld_wire_fault_log faults{};
};

// `recorder` and `sink` may be nullptr. Throws LinkError, RecordingError.
RunResult run_session(Device &device, const Session &session, Recorder *recorder, FrameSink *sink,
                      const RunSettings &settings);

// out/demo.json: the figures of a session.
void write_report(const std::string &path, const RunResult &result, const std::string &scene,
                  const std::vector<Instrument> &tools, const std::string &session);

} // namespace seld
