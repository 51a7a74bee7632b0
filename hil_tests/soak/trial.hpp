// One session against the bars, on the host's own run_session(): hands, device, stents, contrast medium and
// recording are those of `cournand run`, without pictures. It ends at the first tick that breaks a bar; one
// that holds them all is replayed from its recording, tick by tick.
#pragma once
#include "hil_tests/soak/catalogue.hpp"
#include "hil_tests/soak/drawn.hpp"
#include "host/session/recording.hpp"
#include <functional>

namespace soak
{

struct Bars {
    double penetration_mm = 1.0, length_pct = 1.0, force_N = 30.0;
    double iodine_share = 1e-6; // of what was injected, that may be missing
};

// What a session gave. `broken` is the name of the bar: saturation, penetration, length, force, iodine,
// replay, fault (another one of the core), error (an exception, or an input that was refused), crash, time;
// empty when all held.
struct Verdict {
    std::string broken, text; // one sentence
    std::uint32_t tick = 0;   // at which it broke
    std::uint32_t ticks = 0;
    double penetration_mm = 0, length_pct = 0, force_N = 0; // the worst of the session
    std::uint32_t capped = 0;                               // ticks whose motion was scaled down
    double injected_mg = 0;                                 // iodine
    std::uint64_t hash = 0;
    bool was_interrupted = false;
};

struct TrialSettings {
    Bars bars;
    std::uint32_t ticks_max = 120000; // a session that takes longer ends there
    std::string folder;               // for the recording, which is removed again
    bool replays = true;
    std::function<void(crn::Recording &)> disturb{}; // tests: between recording and replay
};

Verdict run_trial(const Catalogue &catalogue, const DrawnSession &session, const TrialSettings &settings);

// The same in a process of its own, so that a crash and an endless loop are verdicts, too.
Verdict run_isolated(const std::function<Verdict()> &trial, double seconds_max);

// A verdict as words separated by tabs, and back. Throws std::runtime_error.
std::string line_of(const Verdict &verdict);
Verdict verdict_of(const std::string &line);

} // namespace soak
