// Shortens a session that exceeds a limit. The functions remove statements and tools, halve numbers and
// simplify commands, as long as the session still exceeds the same limit. The caller limits the number of
// trials and the time that shortening may take.
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

// The function makes shorter and shorter versions of the session, and calls `judge` to run and judge each.
Shrunk shrink(const DrawnSession &session, const Verdict &found,
              const std::function<Verdict(const DrawnSession &)> &judge, const ShrinkLimits &limits = {});

// The pieces, for tests. Returns the session without the given tool: the tool's statements are removed, and
// every tool that lies outside the removed tool gets the name of the next inner tool.
DrawnSession without_tool(const DrawnSession &session, std::size_t tool);
// Returns simpler forms of a script statement; the simplest form comes first.
std::vector<std::string> plainer(const std::string &line);

} // namespace soak
