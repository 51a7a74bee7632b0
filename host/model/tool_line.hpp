// States which tools of a session's table are in use, that is, nested in each other. In the device's
// messages, each position has the number of its tool in the session's table, from 1, or 0 where there is no
// tool (docs/session.md, "Exchange").
#pragma once
#include "host/model/instrument.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace crn
{

using LineNumbers = std::vector<std::uint8_t>;

// Returns the numbers of all tools of the table, in order, for a session that does not name the tools in use.
LineNumbers whole_table(std::size_t tool_count);

// Returns `line`, or the numbers of all tools of the table if `line` is empty.
LineNumbers line_or_table(const LineNumbers &line, std::size_t tool_count);

inline LineNumbers line_of(const crn_wire_tick_state &state)
{
    return {state.line, state.line + state.line_count};
}

// States at which positions the tool has changed: bit k stands for position k (0: innermost). A tool never
// moves to another position, so a position whose bit is 0 has the same tool as before.
using ChangedPositions = std::uint32_t;
ChangedPositions changed_positions(std::span<const std::uint8_t> before, std::span<const std::uint8_t> now);
inline bool has_changed(ChangedPositions changed, std::size_t position)
{
    return (changed >> position & 1u) != 0;
}

// Returns an entry of the table for each position of nested tools. A position without a tool, or a number
// that the table does not have, gets a default entry.
template <class Entry>
std::vector<Entry> entries_on(std::span<const Entry> table, std::span<const std::uint8_t> numbers)
{
    std::vector<Entry> entries;
    for (const std::uint8_t number : numbers)
        entries.push_back(number >= 1 && number <= table.size() ? table[number - 1u] : Entry{});
    return entries;
}

// Returns the tool at each position, from the innermost. At a position without a tool, the function returns
// an instrument without a name, without knots and without a lumen.
std::vector<Instrument> tools_on(std::span<const Instrument> table, std::span<const std::uint8_t> line);

} // namespace crn
