// Counts the instructions of one step by running this same program under callgrind.
#pragma once
#include "tools/lab/figures/study.hpp"

namespace vcsim3
{

// Fills in `instructions` for all times of the study. The command `vcsim3 steps`, called with the additional
// `arguments`, reads each run's state from `states_folder`. Throws std::runtime_error that states what is
// missing or wrong.
void count_instructions(Study &study, const std::string &states_folder,
                        const std::vector<std::string> &arguments, const Report &report);

} // namespace vcsim3
