// Counts the processor instructions of one simulation step by running this program under callgrind.
#pragma once
#include "tools/lab/figures/study.hpp"

namespace vcsim3
{

// Stores the number of instructions per step in the field `instructions` of every time of the study. The
// command `vcsim3 steps`, with the additional `arguments`, reads the state of each run from `states_folder`.
// Throws std::runtime_error, whose message states what is missing or wrong.
void count_instructions(Study &study, const std::string &states_folder,
                        const std::vector<std::string> &arguments, const Report &report);

} // namespace vcsim3
