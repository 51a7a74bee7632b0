// Scores a recorded session. A replay of the recording gives the report, the assessment, and the marks of a
// case. The command `cournand score` and the debrief in the window use this code, so their results are equal,
// byte for byte.
#pragma once
#include "host/cases/case.hpp"
#include "host/command/cli_assess.hpp"
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

namespace crn
{

struct ScoreRequest {
    std::string recording;
    std::string scene, bodies_path; // empty: those of the recording
    PlanOptions plan;               // empty: that of the case, or the standard plan
    const Case *lesson = nullptr;   // whose goals are judged; may be nullptr
    // The following function receives the completed share of the work, 0 to 1, many times per second; if it
    // returns false, the work ends. May be empty.
    std::function<bool(double)> goes_on;
};

struct RecordedScore {
    // Holds the report of the session, with the entries "score" and "assessment", and also "case" if there is
    // a case.
    nlohmann::ordered_json report;
    bool was_stopped = false; // by Ctrl-C or goes_on(): the report is empty
    bool is_complete = true;  // false: the recording was cut off
    std::uint32_t ticks = 0;
    std::string core_version, state_hash; // of the recording; of its last tick
};

// Replays the recording as fast as possible and compares the hash of every tick. Throws std::runtime_error if
// the replay differs from the recording, and the exceptions of the functions that read the files.
RecordedScore score_recording(const ScoreRequest &request);

} // namespace crn
