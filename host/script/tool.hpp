// Which tool a line of a session script names, and words up to the next one of the grammar (docs/session.md).
#pragma once
#include "host/script/line.hpp"
#include "shared/wire/wire.h"
#include <optional>

namespace crn
{

// Tools are numbered from the innermost, 0, as on the wire; a script says wire, catheter, guide, or tool 1
// to 3.
inline constexpr std::size_t session_tools_max = CRN_WIRE_TOOL_MAX;

// Whom a statement moves.
struct ToolChoice {
    std::size_t tool = 0;
    bool is_all = false;
};

// "wire", "catheter", "guide", "tool N" or "together"; nothing when the line goes on with something else.
std::optional<ToolChoice> accept_tool(LineParser &line);
// The same where one must follow; a bare number will do.
ToolChoice require_tool(LineParser &line);
// A statement about one tool: the one that is named, else the selected one, but not all together.
std::size_t accept_one_tool(LineParser &line, const ToolChoice &selected);

// "wire", "catheter", "guide": of tools counted from 0.
const std::string &tool_name(std::size_t tool);

// A vessel as the script writes it; which one it is shows when the scene is known.
struct VesselName {
    std::string text;
    int column = 0;
};
// One or more words up to `at`, `below`, `until`, `within` or the end of the line.
VesselName vessel_name(LineParser &line);

} // namespace crn
