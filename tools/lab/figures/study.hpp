// All results of `vcsim3 figures`, before they are drawn and written.
#pragma once
#include "tools/lab/figures/stability.hpp"
#include "tools/lab/figures/timing.hpp"

namespace vcsim3
{

// The smallest stable number of steps per millisecond of a preset, by mode.
struct StabilityRow {
    const Preset *preset;
    int penalty, local10, global;
};

struct Study {
    const Preset *preset = nullptr;
    Protocol protocol;
    std::vector<CompressionResult> runs; // in the order of the modes, the direct solver last
    std::vector<TimingResult> times;     // in the same order; empty when they were not measured
    std::vector<StabilityRow> stability; // empty when it was not measured
};

// The contents of a study. Modes keep the thesis' order.
struct StudySettings {
    const Preset *preset = nullptr;
    Protocol protocol;
    std::vector<Mode> modes;
    bool with_times = true, with_stability = true;
    int threads = 1;
};

// Reports the current work and its progress: (what, completed share, or -1 for a separate line). It is called
// from several threads, but one at a time. If it returns false, everything stops with Interrupted.
using Report = std::function<bool(const std::string &, double)>;

Study make_study(const StudySettings &settings, const Vessel &vessel, const Report &report);

// The run with this token; nullptr when there is none.
const CompressionResult *find_run(const Study &study, const std::string &token);

// Sentences on requirements for Figure 5.11 (bar 4 of the product) that are not met. The list is empty when
// the order penalty > 5 > 10 > 25 > 50 local holds, no rod became unstable, and the direct solver is below
// every mode.
std::vector<std::string> order_faults(const Study &study);

} // namespace vcsim3
