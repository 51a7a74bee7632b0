// Reads which tool a line of a session script names, and the names of vessels (docs/session.md).
#pragma once
#include "host/script/line.hpp"
#include "shared/wire/wire.h"
#include <optional>

namespace crn
{

// Tools are numbered from the innermost, 0, as in the byte protocol. A script calls the tools wire, catheter
// and guide, or tool 1 to 3.
inline constexpr std::size_t session_tools_max = CRN_WIRE_TOOL_MAX;

// Describes which tool a statement moves: one tool, or all tools together.
struct ToolChoice {
    std::size_t tool = 0;
    bool is_all = false;
};

// Reads "wire", "catheter", "guide", "tool N" or "together"; returns no value if the next word is a different
// one.
std::optional<ToolChoice> accept_tool(LineParser &line);
// Reads the name of a tool where the grammar requires one; a number without the word "tool" is accepted too.
ToolChoice require_tool(LineParser &line);
// Reads the tool of a statement that concerns a single tool. If the statement names no tool, the function
// returns the selected tool; the word "together" is refused.
std::size_t accept_one_tool(LineParser &line, const ToolChoice &selected);

// Returns the name "wire", "catheter" or "guide" of a tool; tool 0 is the innermost one.
const std::string &tool_name(std::size_t tool);

// Holds the name of a vessel as the script spells it; the vessel of this name is looked up when the scene is
// known.
struct VesselName {
    std::string text;
    int column = 0;
};
// Reads the name of a vessel: one or more words up to `at`, `below`, `until`, `within` or the end of the
// line.
VesselName vessel_name(LineParser &line);

} // namespace crn
