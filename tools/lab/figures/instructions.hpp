// Instructions of one step by callgrind, run on this same program.
#pragma once
#include "tools/lab/figures/study.hpp"

namespace vcsim3
{

// Fills `instructions` of every time in the study. Each run's state is read from `states_folder` by
// `vcsim3 steps`, called with `arguments` besides. Throws std::runtime_error that says what is missing or
// wrong.
void count_instructions(Study &study, const std::string &states_folder,
                        const std::vector<std::string> &arguments, const Report &report);

} // namespace vcsim3
