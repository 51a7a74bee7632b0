// Measures the values of the thesis' Figure 5.14: the duration of one time step, phase by phase, for every
// mode of the solver. The measurement of each mode starts from the state at the end of its compression run.
#pragma once
#include "tools/lab/figures/compression.hpp"

namespace vcsim3
{

struct TimingResult {
    std::string name, token;
    PhaseTimes step; // of one step; all of the direct solver's one tick is in `direct_s`
    double direct_s = 0.0;
    int steps_per_ms = 1;
    double instructions = 0.0; // of one step; 0 when they were not counted

    double total_s() const { return direct_s + step.total_s(); }
    double per_ms_s() const { return total_s() * steps_per_ms; }
};

// Measures all runs in turn, round after round, so that a disturbance of the machine does not affect one mode
// alone. For each phase of a step, the function keeps the shortest time of 600 steps. All states in `runs`
// must have been made with the given preset, vessel and protocol.
std::vector<TimingResult> time_steps(const std::vector<CompressionResult> &runs, const Preset &preset,
                                     const Vessel &vessel, const Protocol &protocol, const Watch &watch);

// Advances the state of one run by `count` steps within the function vcsim3_measured_step, whose name is
// passed to callgrind.
void run_measured_steps(const CompressionResult &run, int count, const Preset &preset, const Vessel &vessel,
                        const Protocol &protocol);

} // namespace vcsim3
