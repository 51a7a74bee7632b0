#include "host/model/tool_line.hpp"

namespace crn
{

LineNumbers whole_table(std::size_t tool_count)
{
    LineNumbers line;
    for (std::size_t k = 0; k < tool_count; k++) line.push_back(static_cast<std::uint8_t>(k + 1));
    return line;
}

LineNumbers line_or_table(const LineNumbers &line, std::size_t tool_count)
{
    return line.empty() ? whole_table(tool_count) : line;
}

ChangedPositions changed_positions(std::span<const std::uint8_t> before, std::span<const std::uint8_t> now)
{
    ChangedPositions changed = 0;
    for (std::size_t k = 0; k < now.size(); k++)
        if (k >= before.size() || before[k] != now[k]) changed |= 1u << k;
    return changed;
}

std::vector<Instrument> tools_on(std::span<const Instrument> table, std::span<const std::uint8_t> line)
{
    return entries_on(table, line);
}

} // namespace crn
