// A broken session made short: whatever can be left out, halved or made plainer while the same bar breaks.
// Bounded in trials and in time.
#pragma once
#include "hil_tests/soak/trial.hpp"

namespace soak
{

struct ShrinkLimits {
    std::uint32_t trials = 120;
    double seconds = 180; // of the machine
};

struct Shrunk {
    DrawnSession session;
    Verdict verdict; // of that session
    std::uint32_t trials = 0;
};

// `judge` does a session; it is called for shorter and shorter ones.
Shrunk shrink(const DrawnSession &session, const Verdict &found,
              const std::function<Verdict(const DrawnSession &)> &judge, const ShrinkLimits &limits = {});

// The pieces, for tests. The session without that tool: its statements are left out, the names of the others
// move up.
DrawnSession without_tool(const DrawnSession &session, std::size_t tool);
// Plainer forms of a statement, the plainest first.
std::vector<std::string> plainer(const std::string &line);

} // namespace soak
