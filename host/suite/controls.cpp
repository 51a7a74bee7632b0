// Converts controls of the window to commands to the X-ray room. Most controls change the present state of
// the X-ray room by one step.
#include "host/suite/controls.hpp"
#include "host/room/presets.hpp"
#include <algorithm>
#include <cmath>
#include <iterator>

namespace crn
{
namespace
{

constexpr double angle_step_deg = 5.0, table_step_m = 0.02, height_step_m = 0.01, sid_step_m = 0.05;
constexpr std::int32_t blade_step_permille = 100, store_ms = 10'000, aspirate_ul = 5'000,
                       preset_sod_um = 750'000;
constexpr double shift_step_px = 0.5;
constexpr std::int32_t fields_um[] = {420'000, 320'000, 250'000, 200'000, 150'000};
using Commands = std::vector<RoomCommand>;

std::int32_t rounded(double value)
{
    return static_cast<std::int32_t>(std::lround(value));
}

// Returns the rate that follows `per_second` in the list; the last rate is followed by the first.
template <std::size_t count> std::int32_t next_rate(double per_second, const std::int32_t (&rates)[count])
{
    const auto *at = std::find(std::begin(rates), std::end(rates), rounded(per_second * 100.0));
    return at == std::end(rates) || at + 1 == std::end(rates) ? rates[0] : at[1];
}

// --- geometry: steps from the motors' targets ---

Commands turn(const Room &room, double primary_deg, double secondary_deg)
{
    const GantryPose &target = room.gantry().target();
    return {{RoomAction::angles,
             {std::clamp(rounded((target[axis_primary] + primary_deg) * 1e3), -primary_max_mdeg,
                         primary_max_mdeg),
              std::clamp(rounded((target[axis_secondary] + secondary_deg) * 1e3), -secondary_max_mdeg,
                         secondary_max_mdeg),
              0}}};
}

// When the user moves the table, the table stops following the tip.
Commands move_table(const Room &room, int axis, double step_m)
{
    GantryPose target = room.gantry().target();
    target[static_cast<std::size_t>(axis)] += step_m;
    RoomCommand command{RoomAction::table, {}};
    for (int i = 0; i < 3; ++i)
        command.values[i] = std::clamp(rounded(target[static_cast<std::size_t>(axis_table_x + i)] * 1e6),
                                       -table_max_um, table_max_um);
    return {command};
}

Commands change_distance(const Room &room, double step_m)
{
    const GantryPose &target = room.gantry().target();
    return {{RoomAction::distance,
             {std::clamp(rounded((target[axis_sid] + step_m) * 1e6), sid_min_um, sid_max_um),
              std::clamp(rounded(target[axis_sod] * 1e6), sod_min_um, sod_max_um), 0}}};
}

Commands change_field(const Room &room, int steps)
{
    const std::int32_t present_um = rounded(room.field_m() * 1e6);
    const auto *at = std::find(std::begin(fields_um), std::end(fields_um), present_um);
    const int index = at == std::end(fields_um) ? 1 : static_cast<int>(at - std::begin(fields_um));
    return {{RoomAction::field,
             {fields_um[std::clamp(index + steps, 0, static_cast<int>(std::size(fields_um)) - 1)], 0, 0}}};
}

Commands change_blades(const Room &room, std::int32_t width, std::int32_t height)
{
    const RoomState state = room.state();
    const auto open = [](double share, std::int32_t step) {
        return step == 0 ? rounded(share * 1e3)
                         : std::clamp(rounded(share * 1e3) + step, blade_step_permille, blade_max_permille);
    };
    return {{RoomAction::blades,
             {open(state.open_width_share, width), open(state.open_height_share, height), 0}}};
}

Commands go_to(std::string_view name)
{
    const ViewPreset *view = view_preset(name);
    if (!view) return {};
    return {{RoomAction::distance, {view->sid_um, preset_sod_um, 0}},
            {RoomAction::angles, {view->primary_mdeg, view->secondary_mdeg, 0}},
            {RoomAction::field, {view->field_um, 0, 0}}};
}

// Returns the name of the standard view that a control selects, or an empty text if the control selects none.
std::string_view view_of(ControlId id)
{
    constexpr std::string_view views[] = {
        "ap",      "spider",  "rao-caudal", "rao-caudal-steep", "rao-cranial", "lao-cranial", "lateral",
        "rca-lao", "rca-rao", "arch",       "renal-left",       "renal-right", "iliac-left",  "iliac-right"};
    static_assert(std::size(views) == static_cast<std::size_t>(ControlId::view_iliac_right) -
                                          static_cast<std::size_t>(ControlId::view_ap) + 1);
    if (id < ControlId::view_ap || id > ControlId::view_iliac_right) return "";
    return views[static_cast<std::size_t>(id) - static_cast<std::size_t>(ControlId::view_ap)];
}

Commands geometry_of(ControlId id, const Room &room)
{
    switch (id) {
    case ControlId::lao:
        return turn(room, angle_step_deg, 0.0);
    case ControlId::rao:
        return turn(room, -angle_step_deg, 0.0);
    case ControlId::cranial:
        return turn(room, 0.0, angle_step_deg);
    case ControlId::caudal:
        return turn(room, 0.0, -angle_step_deg);
    case ControlId::table_head:
        return move_table(room, axis_table_y, table_step_m);
    case ControlId::table_feet:
        return move_table(room, axis_table_y, -table_step_m);
    case ControlId::table_right:
        return move_table(room, axis_table_x, -table_step_m);
    case ControlId::table_left:
        return move_table(room, axis_table_x, table_step_m);
    case ControlId::table_up: // the table rises, so a point farther back comes to the isocentre
        return move_table(room, axis_table_z, -height_step_m);
    case ControlId::table_down:
        return move_table(room, axis_table_z, height_step_m);
    case ControlId::sid_more:
        return change_distance(room, sid_step_m);
    case ControlId::sid_less:
        return change_distance(room, -sid_step_m);
    case ControlId::angles_zero:
        return {{RoomAction::angles, {}}};
    case ControlId::halt:
        return {{RoomAction::halt, {}}};
    default:
        return go_to(view_of(id));
    }
}

Commands field_of(ControlId id, const Room &room)
{
    switch (id) {
    case ControlId::field_smaller:
        return change_field(room, 1);
    case ControlId::field_larger:
        return change_field(room, -1);
    case ControlId::blades_narrower:
        return change_blades(room, -blade_step_permille, 0);
    case ControlId::blades_wider:
        return change_blades(room, blade_step_permille, 0);
    case ControlId::blades_lower:
        return change_blades(room, 0, -blade_step_permille);
    case ControlId::blades_higher:
        return change_blades(room, 0, blade_step_permille);
    case ControlId::round:
        return {{RoomAction::iris, {room.state().is_round ? 0 : 1, 0, 0}}};
    default:
        return {};
    }
}

Commands mode_of(ControlId id, const Room &room, const RoomStatus &screen)
{
    const RoomState state = room.state();
    const bool is_dsa = state.program == RunKind::dsa;
    switch (id) {
    case ControlId::follow:
        return {{RoomAction::follow, {state.follows_tip ? 0 : 1, 0, 0}}};
    case ControlId::fluoro_rate:
        return {
            {RoomAction::fluoro_rate, {next_rate(state.fluoro_pulses_per_s, fluoro_rates_centihertz), 0, 0}}};
    case ControlId::program:
        return {{RoomAction::program, {is_dsa ? 0 : 1, 0, 0}}};
    case ControlId::acquire_rate:
        if (is_dsa)
            return {
                {RoomAction::dsa_rate, {next_rate(state.program_pulses_per_s, dsa_rates_centihertz), 0, 0}}};
        return {
            {RoomAction::cine_rate, {next_rate(state.program_pulses_per_s, cine_rates_centihertz), 0, 0}}};
    case ControlId::store:
        return {{RoomAction::store, {store_ms, 0, 0}}};
    case ControlId::roadmap: {
        const bool has_dsa = std::any_of(room.runs().begin(), room.runs().end(),
                                         [](const RoomRun &run) { return run.kind == RunKind::dsa; });
        const std::int32_t wanted = screen.roadmap != RoadmapState::off ? 0 : has_dsa ? 1 : 2;
        return {{RoomAction::roadmap, {wanted, 0, 0}}};
    }
    case ControlId::acknowledge:
        return {{RoomAction::acknowledge, {}}};
    case ControlId::aspirate:
        return {{RoomAction::aspirate, {aspirate_ul, 0, 0}}};
    case ControlId::load_stent:
        return {{RoomAction::load_stent, {}}};
    default:
        return {};
    }
}

// Selects the frame before or after the displayed frame and shows it as a still picture, even if the screen
// shows a held picture or a loop.
Commands step_frame(const RoomStatus &screen, int step)
{
    if (screen.frames == 0) return {{RoomAction::review, {2, 0, 0}}}; // the last run's first frame
    return {{RoomAction::review, {2, screen.run, (screen.frame + step + screen.frames) % screen.frames}}};
}

Commands shift_mask(const RoomStatus &screen, double right_px, double up_px)
{
    const auto held = [](double pixels) {
        return std::clamp(rounded(pixels * 100.0), -shift_max_centipixels, shift_max_centipixels);
    };
    return {
        {RoomAction::shift, {held(screen.shift_right_px + right_px), held(screen.shift_up_px + up_px), 0}}};
}

Commands review_of(ControlId id, const RoomStatus &screen)
{
    switch (id) {
    case ControlId::loop:
        return {{RoomAction::review, {screen.source == ScreenSource::loop ? 0 : 1, 0, 0}}};
    case ControlId::frame_back:
        return step_frame(screen, -1);
    case ControlId::frame_on:
        return step_frame(screen, 1);
    case ControlId::mask:
        return {{RoomAction::mask, {screen.frame, screen.frame, 0}}};
    case ControlId::mask_right:
        return shift_mask(screen, shift_step_px, 0.0);
    case ControlId::mask_left:
        return shift_mask(screen, -shift_step_px, 0.0);
    case ControlId::mask_up:
        return shift_mask(screen, 0.0, shift_step_px);
    case ControlId::mask_down:
        return shift_mask(screen, 0.0, -shift_step_px);
    default:
        return {};
    }
}

} // namespace

std::vector<RoomCommand> commands_of(ControlId id, const Room &room, const RoomStatus &screen)
{
    Commands commands = geometry_of(id, room);
    if (commands.empty()) commands = field_of(id, room);
    if (commands.empty()) commands = mode_of(id, room, screen);
    if (commands.empty()) commands = review_of(id, screen);
    return commands;
}

} // namespace crn
