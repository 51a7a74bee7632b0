#include "host/script/tool.hpp"
#include <algorithm>

namespace crn
{

namespace
{

const std::vector<std::string> tool_names = {"wire", "catheter", "guide"}; // from the innermost
const std::string all_tools = "together";
const std::vector<std::string> words_behind_a_vessel = {"at", "below", "until", "within"};

} // namespace

std::optional<ToolChoice> accept_tool(LineParser &line)
{
    for (std::size_t k = 0; k < tool_names.size(); k++) {
        if (line.accept(tool_names[k])) return ToolChoice{k, false};
    }
    if (line.accept(all_tools)) return ToolChoice{0, true};
    if (!line.accept("tool")) {
        std::vector<std::string> words = tool_names;
        words.push_back(all_tools);
        const std::string hint = suggestion(line.peek(), words);
        if (hint.find("did you mean") != std::string::npos)
            line.fail("unknown tool '" + line.peek() + "'" + hint);
        return {};
    }
    const LineParser before = line;
    const double number = line.number("number of a tool");
    if (number != std::floor(number) || number < 1.0 || number > session_tools_max)
        before.fail("a tool is 1 to " + std::to_string(session_tools_max) + ", from the innermost");
    return ToolChoice{static_cast<std::size_t>(number) - 1, false};
}

ToolChoice require_tool(LineParser &line)
{
    if (const auto choice = accept_tool(line)) return *choice;
    for (std::size_t k = 0; k < session_tools_max; k++) {
        if (line.accept(std::to_string(k + 1))) return {k, false};
    }
    std::vector<std::string> words = tool_names;
    words.insert(words.end(), {all_tools, "tool", "1", "2", "3"});
    line.choice("tool", words);
    return {};
}

std::size_t accept_one_tool(LineParser &line, const ToolChoice &selected)
{
    const LineParser before = line;
    const ToolChoice choice = accept_tool(line).value_or(selected);
    if (choice.is_all) before.fail("this is for one tool: name wire, catheter, guide or tool N");
    return choice.tool;
}

const std::string &tool_name(std::size_t tool)
{
    return tool_names[std::min(tool, tool_names.size() - 1)];
}

VesselName vessel_name(LineParser &line)
{
    VesselName name{"", line.column()};
    const auto is_end = [&] {
        return line.is_at_end() || std::find(words_behind_a_vessel.begin(), words_behind_a_vessel.end(),
                                             line.peek()) != words_behind_a_vessel.end();
    };
    if (is_end()) line.fail("expected the name of a vessel, " + line.found());
    while (!is_end()) {
        name.text += (name.text.empty() ? "" : " ") + line.peek();
        line.skip();
    }
    return name;
}

} // namespace crn
