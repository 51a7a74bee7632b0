// Counts the instructions of one step with callgrind, run on this same program.
#pragma once
#include "tools/lab/figures/study.hpp"

namespace vcsim3
{

// Fills `instructions` of every time in the study. `vcsim3 steps`, called with the additional `arguments`,
// reads each run's state from `states_folder`. Throws std::runtime_error that says what is missing or wrong.
void count_instructions(Study &study, const std::string &states_folder,
                        const std::vector<std::string> &arguments, const Report &report);

} // namespace vcsim3
