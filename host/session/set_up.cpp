#include "host/session/set_up.hpp"

namespace crn
{

namespace
{

// Returns the names of the tools that caused a refusal, as in the tools' files; the text is empty if no tool
// caused the refusal.
std::string tool_at_fault(const std::vector<Instrument> &tools, const LineNumbers &line,
                          const crn_wire_reject &reject)
{
    const std::size_t tool = reject.detail1;
    switch (reject.code) {
    case CRN_REJECT_TOOL_KNOTS:
    case CRN_REJECT_TOOL_RANGE:
    case CRN_REJECT_TOOL_LENGTH:
    case CRN_REJECT_TOOL_ELEMENTS:
    case CRN_REJECT_TOOL_OVERFLOW:
    case CRN_REJECT_TOOL_BALLOON:
    case CRN_REJECT_LENGTH_INSERTED:
        return tool < tools.size() ? "'" + tools[tool].name + "'" : "";
    case CRN_REJECT_TOOL_NESTING:
        for (std::size_t k = 1, inner = line.empty() ? 0 : line[0]; k < line.size(); k++) {
            if (line[k] == 0) continue;
            if (line[k] == tool + 1 && inner > 0) return nesting_refusal(tools[inner - 1], tools[tool]);
            inner = line[k];
        }
        return "";
    default:
        return "";
    }
}

} // namespace

void set_up_session(Link &link, const SessionSetUp &set_up)
{
    std::vector<crn_wire_instrument> tables;
    for (const Instrument &tool : set_up.tools) tables.push_back(tool.table);
    link.load_scene(set_up.scene.bytes, set_up.scene.crc32);
    link.load_tools(tables, set_up.line);
    link.set_entry(set_up.entry);
    link.set_rig(set_up.rig);
    link.use_lockstep();
    link.arm();
    link.start();
}

LinkError with_tool_names(const LinkError &error, const std::vector<Instrument> &tools,
                          const LineNumbers &line)
{
    const std::string who = tool_at_fault(tools, line, error.reject);
    return who.empty() ? error : LinkError(who + ": " + error.what(), error.reject);
}

} // namespace crn
