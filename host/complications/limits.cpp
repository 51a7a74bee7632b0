#include "host/complications/limits.hpp"
#include "host/base/number_text.hpp"
#include "host/base/toml_reader.hpp"
#include <algorithm>
#include <cmath>
#include <iterator>

namespace crn
{
namespace
{

using L = ComplicationLimits;

// Recordings contain the indices of these limits, so their order must never change; new limits are added at
// the end.
constexpr ComplicationLimit limits_table[] = {
    {"perforation_tip_kPa", &L::perforation_tip_kPa, 10, 100'000},
    {"dissection_tip_kPa", &L::dissection_tip_kPa, 10, 100'000},
    {"tip_hold_ms", &L::tip_hold_ms, 0, 60'000},
    {"perforation_balloon_ratio", &L::perforation_balloon_ratio, 1, 10},
    {"dissection_balloon_ratio", &L::dissection_balloon_ratio, 1, 10},
    {"balloon_hold_ms", &L::balloon_hold_ms, 0, 60'000},
    {"balloon_hole_mm", &L::balloon_hole_mm, 0.05, 5},
    {"balloon_hole_mm_per_ratio", &L::balloon_hole_mm_per_ratio, 0, 20},
    {"hole_open_pct", &L::hole_open_pct, 0.1, 100},
    {"crater_below_mm", &L::crater_below_mm, 0, 5},
    {"jet_mm", &L::jet_mm, 0.05, 10},
    {"seal_s", &L::seal_s, 1, 7200},
    {"blush_mg_per_ml", &L::blush_mg_per_ml, 1, 350},
    {"flap_mm", &L::flap_mm, 1, 100},
    {"flap_narrowing_pct", &L::flap_narrowing_pct, 0, 100},
    {"tip_narrowing_pct", &L::tip_narrowing_pct, 0, 1000},
    {"balloon_narrowing_pct", &L::balloon_narrowing_pct, 0, 10'000},
    {"pocket_fill_s", &L::pocket_fill_s, 0.01, 600},
    {"pocket_empty_s", &L::pocket_empty_s, 0.01, 7200},
    {"tamponade_begins_ml", &L::tamponade_begins_ml, 0, 10'000},
    {"tamponade_full_ml", &L::tamponade_full_ml, 1, 10'000},
    {"shock_begins_ml", &L::shock_begins_ml, 0, 10'000},
    {"shock_full_ml", &L::shock_full_ml, 1, 10'000},
    {"pressure_left_pct", &L::pressure_left_pct, 5, 100},
};
static_assert(std::size(limits_table) == complication_limit_count);

constexpr double per_unit = 1000.0; // a command holds thousandths

std::int32_t thousandths(double value)
{
    return static_cast<std::int32_t>(std::lround(value * per_unit));
}

struct Pair {
    const char *low, *high;
    double L::*lower, L::*higher;
};
constexpr Pair pairs[] = {
    {"dissection_tip_kPa", "perforation_tip_kPa", &L::dissection_tip_kPa, &L::perforation_tip_kPa},
    {"dissection_balloon_ratio", "perforation_balloon_ratio", &L::dissection_balloon_ratio,
     &L::perforation_balloon_ratio},
    {"crater_below_mm", "jet_mm", &L::crater_below_mm, &L::jet_mm},
    {"tamponade_begins_ml", "tamponade_full_ml", &L::tamponade_begins_ml, &L::tamponade_full_ml},
    {"shock_begins_ml", "shock_full_ml", &L::shock_begins_ml, &L::shock_full_ml},
};

std::string pair_fault(const ComplicationLimits &limits, const Pair &pair)
{
    if (limits.*pair.lower < limits.*pair.higher) return "";
    return std::string("'") + pair.low + "' = " + number_text(limits.*pair.lower) + " is not below '" +
           pair.high + "' = " + number_text(limits.*pair.higher);
}

} // namespace

std::span<const ComplicationLimit> complication_limits()
{
    return limits_table;
}

std::string limits_fault(const ComplicationLimits &limits)
{
    for (const Pair &pair : pairs)
        if (const std::string fault = pair_fault(limits, pair); !fault.empty()) return fault;
    return "";
}

ComplicationLimits read_complications(const std::string &path)
{
    const TomlTable root =
        read_toml(path, {"limits of complications", "a file of limits, or 'off'", "; it is no such file"});
    std::vector<std::string> known = {"format", "name", "sources"};
    for (const ComplicationLimit &limit : limits_table) known.emplace_back(limit.key);
    root.check_keys(known);
    root.check_format(1);
    if (root.has("name")) root.words("name");
    root.read_sources();
    ComplicationLimits limits;
    for (const ComplicationLimit &limit : limits_table)
        if (root.has(limit.key))
            limits.*limit.value = thousandths(root.sourced(limit.key, {limit.low, limit.high})) / per_unit;
    root.check_sources_used();
    for (const Pair &pair : pairs) {
        const std::string fault = pair_fault(limits, pair);
        if (fault.empty()) continue;
        const char *stated = root.has(pair.low) ? pair.low : pair.high;
        root[stated].fail(fault);
    }
    return limits;
}

std::vector<RoomCommand> commands_of(const ComplicationLimits &limits)
{
    const ComplicationLimits shipped;
    std::vector<RoomCommand> commands;
    for (std::size_t i = 0; i < std::size(limits_table); ++i) {
        const ComplicationLimit &limit = limits_table[i];
        if (limits.*limit.value != shipped.*limit.value)
            commands.push_back({RoomAction::complication_limit,
                                {static_cast<std::int32_t>(i), thousandths(limits.*limit.value), 0}});
    }
    if (limits.is_on != shipped.is_on)
        commands.push_back({RoomAction::complications, {limits.is_on ? 1 : 0, 0, 0}});
    return commands;
}

void take_command(ComplicationLimits &limits, const RoomCommand &command)
{
    if (command.action == RoomAction::complications) limits.is_on = command.values[0] != 0;
    if (command.action != RoomAction::complication_limit) return;
    const ComplicationLimit &limit = limits_table[static_cast<std::size_t>(command.values[0])];
    limits.*limit.value = std::clamp(command.values[1] / per_unit, limit.low, limit.high);
}

} // namespace crn
