// Everything `vcsim3 figures` finds out, before it is drawn and written.
#pragma once
#include "tools/lab/figures/stability.hpp"
#include "tools/lab/figures/timing.hpp"

namespace vcsim3
{

// Smallest stable steps per millisecond of a preset, by mode.
struct StabilityRow {
    const Preset *preset;
    int penalty, local10, global;
};

struct Study {
    const Preset *preset = nullptr;
    Protocol protocol;
    std::vector<CompressionResult> runs; // in the order of the modes, the direct solver last
    std::vector<TimingResult> times;     // same order; empty when they were not taken
    std::vector<StabilityRow> stability; // empty when it was not measured
};

// What a study is to hold. Modes keep the thesis' order.
struct StudySettings {
    const Preset *preset = nullptr;
    Protocol protocol;
    std::vector<Mode> modes;
    bool with_times = true, with_stability = true;
    int threads = 1;
};

// Says what is being done and how far it is: (what, share done or -1 for a line of its own). From several
// threads, but one at a time. A false answer stops everything with Interrupted.
using Report = std::function<bool(const std::string &, double)>;

Study make_study(const StudySettings &settings, const Vessel &vessel, const Report &report);

// The run with this token; nullptr when there is none.
const CompressionResult *find_run(const Study &study, const std::string &token);

// Sentences on what Figure 5.11 has to show and does not (bar 4 of the product): empty when the order
// penalty > 5 > 10 > 25 > 50 local holds, nothing burst, and the direct solver is below every mode.
std::vector<std::string> order_faults(const Study &study);

} // namespace vcsim3
