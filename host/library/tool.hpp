// Holds a tool of the API: an instrument as its file states it, or with scaled values.
#pragma once
#include "host/library/handles.hpp"
#include "host/model/instrument.hpp"

namespace crn::library
{

// Holds an instrument, and the word by which a script names it: its file's name without folder and ending.
struct NamedTool : Instrument {
    std::string word;
};
// Throws FileError.
NamedTool open_tool(const std::string &path);

void describe(const Instrument &tool, cournand_tool_info &info);
// Returns the middles of the marker bands of the tool in m from its tip, in ascending order.
std::vector<double> marker_arcs(const Instrument &tool);
// Throws Refused if a factor is out of its range.
Instrument scaled(const Instrument &tool, const cournand_tool_scales &scales);

template <> struct HandleOf<cournand_tool> {
    using Object = NamedTool;
    static constexpr HandleKind kind = HandleKind::tool;
    static constexpr char name[] = "tool";
};

} // namespace crn::library
