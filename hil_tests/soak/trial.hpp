// Runs one session with the host's own run_session(), and judges it by the limits of docs/soak.md, which are
// called bars. Hands, device, stents, contrast medium and recording work as in `cournand run`, but no
// pictures are made. The session ends at the first tick that exceeds a limit. A session that exceeds no limit
// is replayed from its recording, tick by tick.
#pragma once
#include "hil_tests/soak/catalogue.hpp"
#include "hil_tests/soak/drawn.hpp"
#include "host/session/recording.hpp"
#include <functional>

namespace soak
{

struct Bars {
    double penetration_mm = 1.0, length_pct = 1.0, force_N = 30.0;
    double iodine_share = 1e-6; // share of the injected iodine that may be missing
};

// The result of a session. `broken` is the name of the exceeded limit, or empty if the session exceeded no
// limit. The limits have these names: saturation, penetration, length, force, iodine, replay, fault (another
// fault of the core), error (an exception, or a refused input), crash and time.
struct Verdict {
    std::string broken, text; // one sentence
    std::uint32_t tick = 0;   // at which it broke
    std::uint32_t ticks = 0;
    double penetration_mm = 0, length_pct = 0, force_N = 0; // the worst values of the session
    std::uint32_t capped = 0;                               // ticks whose motion was scaled down
    double injected_mg = 0;                                 // iodine
    std::uint64_t hash = 0;
    bool was_interrupted = false;
};

struct TrialSettings {
    Bars bars;
    std::uint32_t ticks_max = 120000; // a session that takes longer ends at this tick
    std::string folder;               // for the recording, which is removed afterwards
    bool replays = true;
    std::function<void(crn::Recording &)> disturb{}; // for tests: called between recording and replay
};

Verdict run_trial(const Catalogue &catalogue, const DrawnSession &session, const TrialSettings &settings);

// Runs and judges the session in a separate process, so that a crash and an endless loop also give a verdict.
Verdict run_isolated(const std::function<Verdict()> &trial, double seconds_max);

// The functions line_of and verdict_of convert a verdict to words that are separated by tabs, and back.
// Throws std::runtime_error.
std::string line_of(const Verdict &verdict);
Verdict verdict_of(const std::string &line);

} // namespace soak
