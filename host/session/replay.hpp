// Replays a recording on a newly started device and compares every state hash.
#pragma once
#include "host/patient/patient.hpp"
#include "host/script/tip_places.hpp"
#include "host/session/contact_figures.hpp"
#include "host/session/device.hpp"
#include "host/session/frame_sink.hpp"
#include <optional>

namespace crn
{

// States the speed of the replay: 1 is real time, and 0 is as fast as the machine can compute.
struct ReplaySpeed {
    double factor = 0.0;
    bool is_paused = false; // one tick at a time around every full second, with a pause there
};

// Converts "fast", "slow" (half of real time), "paused" or a positive number to a speed; returns nullopt for
// any other text.
std::optional<ReplaySpeed> replay_speed(const std::string &text);

struct ReplaySettings {
    ReplaySpeed speed;
    bool verifies = false;
    double from_s = 0.0;            // start at the snapshot before this time, then step up to it
    bool waits_for_enter = false;   // paused, and a person uses the terminal
    bool measures_contacts = false; // ReplayResult::contacts
};

struct ReplayResult {
    SessionFigures figures;
    ContactFigures contacts;
    std::vector<TipPlace> tips; // places after the last tick; filled by the caller that has the vessels
    LineNumbers line;           // after the last tick; empty if no tick was replayed
    crn_wire_fault_log faults{};
    double seconds = 0.0; // wall clock
    std::uint32_t tick = 0;
    std::uint64_t hash = 0;
    std::uint32_t ticks_compared = 0;
    std::uint32_t hashes_compared = 0;
    bool was_interrupted = false;
    std::optional<std::uint32_t> first_difference_tick;
    std::string difference; // the difference found
};

// `patient` and `sink` may be nullptr, because the recording contains the commands to the core. Throws
// LinkError. If `verifies` is true, the replay stops at the first tick whose hash differs from the recorded
// hash.
ReplayResult replay_recording(Device &device, const Recording &recording, Patient *patient, FrameSink *sink,
                              const ReplaySettings &settings);

} // namespace crn
