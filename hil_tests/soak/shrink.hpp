// Makes a broken session short: everything is left out, halved or simplified as long as the same bar breaks.
// It is bounded in trials and in time.
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

// `judge` runs a session; it is called for shorter and shorter ones.
Shrunk shrink(const DrawnSession &session, const Verdict &found,
              const std::function<Verdict(const DrawnSession &)> &judge, const ShrinkLimits &limits = {});

// The pieces, for tests. The session without that tool: its statements are left out, and the names of the
// others move up.
DrawnSession without_tool(const DrawnSession &session, std::size_t tool);
// Returns the simpler forms of a statement, the simplest first.
std::vector<std::string> plainer(const std::string &line);

} // namespace soak
