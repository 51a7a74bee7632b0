// Holds all results of `vcsim3 figures` before they are drawn and written.
#pragma once
#include "tools/lab/figures/stability.hpp"
#include "tools/lab/figures/timing.hpp"

namespace vcsim3
{

// Holds, for each mode, the smallest number of steps per millisecond with which a preset's rod is stable.
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

// Receives the name of the current work and its completed fraction; if the fraction is -1, the name is
// printed as a separate line. Several threads call the report function, but never two of them at the same
// time. If the report function returns false, all work stops and throws Interrupted.
using Report = std::function<bool(const std::string &, double)>;

Study make_study(const StudySettings &settings, const Vessel &vessel, const Report &report);

// Returns the run of the mode with the given short name, or nullptr if there is none.
const CompressionResult *find_run(const Study &study, const std::string &token);

// Returns one sentence for each violated requirement on Figure 5.11 (requirement 4 of the product). The list
// of violated requirements is empty when three conditions hold. The conditions are: the compression falls in
// the order penalty > 5 > 10 > 25 > 50 local, no rod became unstable, and the direct solver has the least
// compression.
std::vector<std::string> order_faults(const Study &study);

} // namespace vcsim3
