// Figure 5.14: what one step costs, phase by phase, for every mode from the end of its own compression run.
#pragma once
#include "tools/lab/figures/compression.hpp"

namespace vcsim3
{

struct TimingResult {
    std::string name, token;
    PhaseTimes step; // of one step; the direct solver's one tick is all in `direct_s`
    double direct_s = 0.0;
    int steps_per_ms = 1;
    double instructions = 0.0; // of one step; 0 when they were not counted

    double total_s() const { return direct_s + step.total_s(); }
    double per_ms_s() const { return total_s() * steps_per_ms; }
};

// Times all runs in turn, round after round, so that a disturbance of the machine does not fall on one mode,
// and keeps the fastest time of each phase in 600 steps. Needs the states of `runs`, made with the same
// preset, vessel and protocol.
std::vector<TimingResult> time_steps(const std::vector<CompressionResult> &runs, const Preset &preset,
                                     const Vessel &vessel, const Protocol &protocol, const Watch &watch);

// Steps the state of one run so many times within the function whose name callgrind is told (measured_steps).
void run_measured_steps(const CompressionResult &run, int count, const Preset &preset, const Vessel &vessel,
                        const Protocol &protocol);

} // namespace vcsim3
