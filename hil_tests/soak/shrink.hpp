// This header makes a broken session short: everything is left out, halved or simplified as long as the same
// bar breaks. The shrinking is limited in trials and in time.
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

// `judge` runs a session, and is called for shorter and shorter sessions.
Shrunk shrink(const DrawnSession &session, const Verdict &found,
              const std::function<Verdict(const DrawnSession &)> &judge, const ShrinkLimits &limits = {});

// The pieces, for tests. Returns the session without that tool: the tool's statements are left out, and the
// tools outside of it get the names of their inner neighbours.
DrawnSession without_tool(const DrawnSession &session, std::size_t tool);
// Returns the simpler forms of a statement, the simplest first.
std::vector<std::string> plainer(const std::string &line);

} // namespace soak
