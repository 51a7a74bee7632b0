// Runs one command in a separate process with a device that sends one false message (a lie). The verdict
// states how the command ended, how long it took, how long it took to end after Ctrl-C, and whether the
// recording is false.
#pragma once
#include "hil_tests/lies/commands.hpp"

namespace hil
{

struct LieCase {
    const LiedTo *command = nullptr;
    Lie lie;
};

struct Verdict {
    int code = -1;             // exit code; -1: none
    double seconds = 0.0;      // until it ended
    double interrupt_s = -1.0; // from Ctrl-C on; -1: it had ended by itself before
    bool has_struck = false;
    bool is_false = false; // a falsehood was recorded
    std::string message;   // its last line on stderr
    std::string failure;   // empty: everything is as it must be
};

inline constexpr double lie_limit_s = 10.0, lie_interrupt_limit_s = 1.0;

std::vector<LieCase> cases_of(std::size_t lies_per_command); // 0: all.
// Runs and judges all test cases in `cases`, with `jobs` of them running at the same time. `tell` may be
// empty. Ctrl-C ends it early. The recording of a session contains a snapshot only if the session has 5,000
// ticks or more.
std::vector<Verdict> judge(const std::vector<LieCase> &cases, unsigned jobs, unsigned ticks,
                           const std::function<void(std::size_t done)> &tell);

} // namespace hil
