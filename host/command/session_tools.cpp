// Reads the tools that the command line names: the session's table of tools, and which of them are in the
// vessels at the start (docs/session.md, "Exchange").
#include "host/command/cli.hpp"
#include <filesystem>
#include <set>

namespace crn
{

std::vector<NamedPath> tool_inputs(const std::string &instrument, const std::vector<std::string> &tools)
{
    std::vector<NamedPath> inputs;
    if (!instrument.empty()) inputs.push_back({"--instrument", split_preset(instrument).first});
    for (const std::string &tool : tools) inputs.push_back({"--tool", split_preset(tool).first});
    return inputs;
}

std::vector<Instrument> read_tools(const std::string &instrument, const std::vector<std::string> &tools,
                                   std::size_t most)
{
    std::vector<std::string> names = tools;
    if (!instrument.empty()) names.insert(names.begin(), instrument);
    if (names.empty())
        throw UsageError("--tool is required: name one to three instrument files (docs/instruments.md)");
    if (names.size() > most) {
        throw UsageError("--tool: " + std::string(most > CRN_WIRE_TOOL_MAX ? "a session" : "a line") +
                         " holds at most " + std::to_string(most) + " tools, " +
                         std::to_string(names.size()) + " are named");
    }
    std::vector<Instrument> read;
    for (const std::string &name : names) read.push_back(read_instrument(name));
    return read;
}

std::vector<std::string> tool_words(const std::string &instrument, const std::vector<std::string> &tools)
{
    std::vector<std::string> words;
    for (const NamedPath &input : tool_inputs(instrument, tools))
        words.push_back(std::filesystem::path(input.path).stem().string());
    return words;
}

LineNumbers line_numbers(const std::vector<std::string> &words, const std::string &instrument,
                         const std::vector<std::string> &tools)
{
    const std::vector<std::string> names = tool_words(instrument, tools);
    if (words.empty() && names.size() > CRN_WIRE_TOOL_MAX)
        throw UsageError(
            std::to_string(names.size()) +
            " tools are named: say with --line which of them are on the line at the start, one to " +
            std::to_string(CRN_WIRE_TOOL_MAX));
    if (words.size() > CRN_WIRE_TOOL_MAX)
        throw UsageError("--line: a line has at most " + std::to_string(CRN_WIRE_TOOL_MAX) + " positions, " +
                         std::to_string(words.size()) + " are named");
    Session asked{"--line", {}, {}, {}};
    asked.line_names = words;
    LineNumbers line;
    try {
        line = resolve_tools(asked, names);
    } catch (const FileError &error) {
        throw UsageError(error.what());
    }
    std::set<std::uint8_t> seen;
    for (const std::uint8_t number : line)
        if (number != 0 && !seen.insert(number).second)
            throw UsageError("--line: names the tool '" + names[number - 1u] + "' twice");
    if (!words.empty() && seen.empty())
        throw UsageError("--line: names no tool: at least one position must have one");
    return line;
}

} // namespace crn
