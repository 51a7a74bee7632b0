// Checks that every value of a command is within its range.
#include "host/room/command.hpp"
#include <algorithm>
#include <iterator>

namespace crn
{
namespace
{

struct Range {
    std::int32_t low, high;
};

struct Rule {
    RoomAction action;
    const char *name;
    Range ranges[3];
};

constexpr std::int32_t number_max = 1'000'000; // of runs and frames
constexpr Rule rules[] = {
    {RoomAction::fluoro_pedal, "fluoroscopy pedal", {{0, 1}}},
    {RoomAction::acquire_pedal, "acquisition pedal", {{0, 1}}},
    {RoomAction::program, "program", {{0, 1}}},
    {RoomAction::fluoro_rate, "fluoroscopy rate", {{375, 3000}}},
    {RoomAction::cine_rate, "cine rate", {{750, 3000}}},
    {RoomAction::dsa_rate, "DSA rate", {{50, 750}}},
    {RoomAction::angles,
     "angles",
     {{-primary_max_mdeg, primary_max_mdeg}, {-secondary_max_mdeg, secondary_max_mdeg}}},
    {RoomAction::table,
     "table",
     {{-table_max_um, table_max_um}, {-table_max_um, table_max_um}, {-table_max_um, table_max_um}}},
    {RoomAction::follow, "follow", {{0, 1}}},
    {RoomAction::field, "field", {{field_min_um, field_max_um}}},
    {RoomAction::distance, "distance", {{sid_min_um, sid_max_um}, {sod_min_um, sod_max_um}}},
    {RoomAction::blades,
     "blades",
     {{blade_min_permille, blade_max_permille}, {blade_min_permille, blade_max_permille}}},
    {RoomAction::iris, "iris", {{0, 1}}},
    {RoomAction::store, "store", {{store_min_ms, store_max_ms}}},
    {RoomAction::mask, "mask", {{0, number_max}, {0, number_max}}},
    {RoomAction::shift,
     "shift",
     {{-shift_max_centipixels, shift_max_centipixels}, {-shift_max_centipixels, shift_max_centipixels}}},
    {RoomAction::roadmap, "roadmap", {{0, 2}}},
    {RoomAction::review, "review", {{0, 2}, {0, number_max}, {0, number_max}}},
    {RoomAction::acknowledge, "acknowledge", {}},
    {RoomAction::halt, "halt", {}},
    {RoomAction::inject, "injection", {{0, inject_max_ul}, {0, inject_rate_max_ul_s}, {0, 3}}},
    {RoomAction::contrast_strength,
     "strength of the contrast medium",
     {{strength_min_mg_ml, strength_max_mg_ml}}},
    {RoomAction::aspirate, "aspiration", {{1, aspirate_max_ul}}},
    {RoomAction::load_stent, "load stent", {}},
    {RoomAction::complications, "complications", {{0, 1}}},
    {RoomAction::complication_limit,
     "limit of a complication",
     {{0, complication_limit_count - 1}, {0, complication_max_milli}}},
};

template <std::size_t count> bool is_one_of(std::int32_t value, const std::int32_t (&values)[count])
{
    return std::find(std::begin(values), std::end(values), value) != std::end(values);
}

bool is_known_rate(const RoomCommand &command)
{
    switch (command.action) {
    case RoomAction::fluoro_rate:
        return is_one_of(command.values[0], fluoro_rates_centihertz);
    case RoomAction::cine_rate:
        return is_one_of(command.values[0], cine_rates_centihertz);
    case RoomAction::dsa_rate:
        return is_one_of(command.values[0], dsa_rates_centihertz);
    default:
        return true;
    }
}

} // namespace

std::string refusal(const RoomCommand &command)
{
    const auto *rule = std::find_if(std::begin(rules), std::end(rules),
                                    [&](const Rule &r) { return r.action == command.action; });
    if (rule == std::end(rules))
        return "action " + std::to_string(static_cast<int>(command.action)) + " is not known";
    for (int i = 0; i < 3; ++i) {
        const Range &range = rule->ranges[i];
        const std::int32_t value = command.values[i];
        if (value >= range.low && value <= range.high) continue;
        return std::string(rule->name) + ": value " + std::to_string(i + 1) + " is " + std::to_string(value) +
               ", allowed " + std::to_string(range.low) + " to " + std::to_string(range.high);
    }
    if (!is_known_rate(command))
        return std::string(rule->name) + ": no such rate: " + std::to_string(command.values[0]) +
               "/100 per s";
    if (command.action == RoomAction::mask && command.values[0] > command.values[1])
        return "mask: its first frame comes after its last";
    if (command.action == RoomAction::inject && command.values[0] > 0 && command.values[1] == 0)
        return "injection: a volume without a rate";
    return "";
}

void archive_command(StateArchive &state, RoomCommand &command)
{
    auto action = static_cast<std::uint16_t>(command.action);
    state.integer(action);
    command.action = static_cast<RoomAction>(action);
    for (std::int32_t &value : command.values) state.integer(value);
    if (state.restores()) state.require(refusal(command).empty());
}

void archive_refusal(StateArchive &state, Refusal &refusal)
{
    state.integer(refusal.tick);
    state.text(refusal.why);
}

} // namespace crn
