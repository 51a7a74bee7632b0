// Reads the tool that a line of a session script names, and the words up to the next one of the grammar
// (docs/session.md).
#pragma once
#include "host/script/line.hpp"
#include "shared/wire/wire.h"
#include <optional>

namespace crn
{

// Tools are numbered from the innermost, 0, as in the byte protocol. A script calls them wire, catheter and
// guide, or tool 1 to 3.
inline constexpr std::size_t session_tools_max = CRN_WIRE_TOOL_MAX;

// Names the tool, or all tools, that a statement moves.
struct ToolChoice {
    std::size_t tool = 0;
    bool is_all = false;
};

// Reads "wire", "catheter", "guide", "tool N" or "together"; returns nothing if the next word is another one.
std::optional<ToolChoice> accept_tool(LineParser &line);
// Reads the name of a tool where the grammar requires one; a number alone is accepted too.
ToolChoice require_tool(LineParser &line);
// Reads the tool of a statement that concerns a single tool. If the statement names no tool, the selected
// tool is returned; "together" is refused.
std::size_t accept_one_tool(LineParser &line, const ToolChoice &selected);

// Returns "wire", "catheter" or "guide" for a tool counted from 0.
const std::string &tool_name(std::size_t tool);

// Holds the name of a vessel as the script spells it; it is looked up when the scene is known.
struct VesselName {
    std::string text;
    int column = 0;
};
// Reads one or more words up to `at`, `below`, `until`, `within` or the end of the line.
VesselName vessel_name(LineParser &line);

} // namespace crn
