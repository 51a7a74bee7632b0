#include "host/app/window_keys.hpp"
#include "host/room/presets.hpp"
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace crn
{
namespace
{

constexpr std::int64_t push_um_per_s = 30'000, push_slow_um_per_s = 6'000;
constexpr std::int64_t turn_counts_per_second = counts_per_turn / 2,
                       turn_slow_counts_per_s = counts_per_turn / 12;
constexpr double angle_step_deg = 5.0, table_step_m = 0.02, height_step_m = 0.01, sid_step_m = 0.05;
constexpr std::int32_t blade_step_permille = 100, store_ms = 10'000;
constexpr double shift_step_px = 0.5;
constexpr std::int32_t injection_rates_ul_s[] = {1000, 2000, 4000, 8000, 15000, 25000};
constexpr std::int32_t fields_um[] = {420'000, 320'000, 250'000, 200'000, 150'000};
// The keys F2, F3 and so on select the standard views of the C-arm in this list. If a key has two views,
// Shift together with the key selects the second view.
struct PresetKey {
    std::string_view plain, shifted;
};
constexpr PresetKey preset_keys[] = {{"ap", ""},
                                     {"spider", ""},
                                     {"rao-caudal", "rao-caudal-steep"},
                                     {"rao-cranial", ""},
                                     {"lao-cranial", ""},
                                     {"lateral", ""},
                                     {"rca-lao", ""},
                                     {"rca-rao", ""},
                                     {"arch", ""},
                                     {"renal-left", "renal-right"},
                                     {"iliac-left", "iliac-right"}};

std::int32_t rounded(double value)
{
    return static_cast<std::int32_t>(std::lround(value));
}

// Returns the rate that follows `per_second` in the list; after the last rate comes the first.
template <std::size_t count> std::int32_t next_rate(double per_second, const std::int32_t (&rates)[count])
{
    const auto *at = std::find(std::begin(rates), std::end(rates), rounded(per_second * 100.0));
    return at == std::end(rates) || at + 1 == std::end(rates) ? rates[0] : at[1];
}

} // namespace

std::vector<std::string> help_panel(std::size_t tool_count)
{
    std::vector<std::string> lines = {"KEYS                             H or F1 hides this",
                                      "",
                                      "Up / Down         push / pull the tool",
                                      "Left / Right      turn it        (Shift: slowly)",
                                      "Space / C         hold: fluoroscopy / acquisition pedal",
                                      "F                 fluoroscopy stays on / off",
                                      "E  Y              hold: inject contrast (4 ml/s); its rate",
                                      "U                 hold: inflate the balloon  (Shift: deflate)",
                                      "9                 next stent onto the balloon, withdrawn",
                                      "P  X  O           fluoro rate, cine or DSA, its rate",
                                      "",
                                      "D / A   W / S     C-arm to LAO / RAO, to CRA / CAU",
                                      "0                 back to AP       (Z: stop all motors)",
                                      "F2 ... F12        AP  spider  RAO caudal  RAO cranial",
                                      "                  LAO cranial  lateral  RCA LAO  RCA RAO",
                                      "                  arch  left renal  left iliac",
                                      "  with Shift      F4 steep RAO caudal  F11 F12 right",
                                      "I K J L           table: head feet right left",
                                      "Page Up / Down    table up / down",
                                      "Home / End        detector away / nearer (SID)",
                                      "T                 follow the tip on / off",
                                      "+ / -             smaller / larger field",
                                      "[ ]   Ctrl [ ]    blades: width, height   (Q: round)",
                                      "",
                                      "V   , / .         review the last run; frame by frame",
                                      "B                 keep the last 10 s of fluoroscopy",
                                      "N                 frame on the screen becomes the mask",
                                      "Ctrl + arrows     shift the mask",
                                      "M                 roadmap on / off",
                                      "Backspace         dose alert or reminder seen",
                                      "4 / 5   6   7   8 heart slower / faster, premature beat,",
                                      "                  asystole, breath hold on / off",
                                      "R  start again                                  Esc  end"};
    if (tool_count > 1) {
        const std::string numbers = tool_count == 2 ? "1 2 or Tab        " : "1 2 3 or Tab      ";
        lines.insert(lines.begin() + 2, {numbers + "choose the tool, innermost first",
                                         "G                 move all together on / off"});
    }
    return lines;
}

void WindowKeys::ask(RoomAction action, std::int32_t a, std::int32_t b, std::int32_t c)
{
    commands_.push_back({action, {a, b, c}});
}

void WindowKeys::take(const Screen::KeyEvent &event, const RoomScreen &screen)
{
    if (event.key == GLFW_KEY_LEFT_CONTROL || event.key == GLFW_KEY_RIGHT_CONTROL)
        is_control_down_ = !event.is_release;
    if (event.key == GLFW_KEY_LEFT_SHIFT || event.key == GLFW_KEY_RIGHT_SHIFT)
        is_shift_down_ = !event.is_release;
    if (event.is_release) return;
    take_geometry(event.key, screen);
    take_collimator(event.key, screen);
    take_review(event.key, screen);
    if (!event.is_press) return; // other keys do not repeat
    take_mode(event.key, screen);
    take_switch(event.key);
    take_rhythm(event.key);
    if (event.key >= GLFW_KEY_F2 && event.key <= GLFW_KEY_F12)
        go_to(static_cast<std::size_t>(event.key - GLFW_KEY_F2));
}

void WindowKeys::take_geometry(int key, const RoomScreen &screen)
{
    switch (key) {
    case GLFW_KEY_D:
        return turn(screen, angle_step_deg, 0.0);
    case GLFW_KEY_A:
        return turn(screen, -angle_step_deg, 0.0);
    case GLFW_KEY_W:
        return turn(screen, 0.0, angle_step_deg);
    case GLFW_KEY_S:
        return turn(screen, 0.0, -angle_step_deg);
    case GLFW_KEY_I:
        return move_table(screen, axis_table_y, table_step_m);
    case GLFW_KEY_K:
        return move_table(screen, axis_table_y, -table_step_m);
    case GLFW_KEY_J:
        return move_table(screen, axis_table_x, -table_step_m);
    case GLFW_KEY_L:
        return move_table(screen, axis_table_x, table_step_m);
    case GLFW_KEY_PAGE_UP: // the table rises, so a point farther back comes to the isocentre
        return move_table(screen, axis_table_z, -height_step_m);
    case GLFW_KEY_PAGE_DOWN:
        return move_table(screen, axis_table_z, height_step_m);
    case GLFW_KEY_HOME:
        return change_distance(screen, sid_step_m);
    case GLFW_KEY_END:
        return change_distance(screen, -sid_step_m);
    default:
        break;
    }
}

void WindowKeys::take_collimator(int key, const RoomScreen &screen)
{
    switch (key) {
    case GLFW_KEY_EQUAL:
    case GLFW_KEY_KP_ADD:
        return change_field(screen, 1);
    case GLFW_KEY_MINUS:
    case GLFW_KEY_KP_SUBTRACT:
        return change_field(screen, -1);
    case GLFW_KEY_LEFT_BRACKET:
    case GLFW_KEY_RIGHT_BRACKET: {
        const RoomStatus status = screen.status();
        std::int32_t width = rounded(status.open_width_share * 1e3),
                     height = rounded(status.open_height_share * 1e3);
        std::int32_t &open = is_control_down_ ? height : width;
        open += key == GLFW_KEY_RIGHT_BRACKET ? blade_step_permille : -blade_step_permille;
        open = std::clamp(open, blade_step_permille, blade_max_permille);
        return ask(RoomAction::blades, width, height);
    }
    default:
        break;
    }
}

void WindowKeys::take_mode(int key, const RoomScreen &screen)
{
    const RoomStatus status = screen.status();
    const bool is_dsa = status.program == RunKind::dsa;
    switch (key) {
    case GLFW_KEY_0:
    case GLFW_KEY_KP_0:
        return ask(RoomAction::angles);
    case GLFW_KEY_Z:
        return ask(RoomAction::halt);
    case GLFW_KEY_Q:
        return ask(RoomAction::iris, status.is_round ? 0 : 1);
    case GLFW_KEY_T:
        return ask(RoomAction::follow, status.follows_tip ? 0 : 1);
    case GLFW_KEY_P:
        return ask(RoomAction::fluoro_rate, next_rate(status.fluoro_pulses_per_s, fluoro_rates_centihertz));
    case GLFW_KEY_X:
        return ask(RoomAction::program, is_dsa ? 0 : 1);
    case GLFW_KEY_O:
        if (is_dsa)
            return ask(RoomAction::dsa_rate, next_rate(status.program_pulses_per_s, dsa_rates_centihertz));
        return ask(RoomAction::cine_rate, next_rate(status.program_pulses_per_s, cine_rates_centihertz));
    case GLFW_KEY_B:
        return ask(RoomAction::store, store_ms);
    case GLFW_KEY_N:
        return ask(RoomAction::mask, status.frame, status.frame);
    case GLFW_KEY_M:
        if (status.roadmap != RoadmapState::off) return ask(RoomAction::roadmap, 0);
        return ask(RoomAction::roadmap, screen.store().last_of(RunKind::dsa) ? 1 : 2);
    case GLFW_KEY_BACKSPACE:
        return ask(RoomAction::acknowledge);
    default:
        break;
    }
}

void WindowKeys::take_review(int key, const RoomScreen &screen)
{
    switch (key) {
    case GLFW_KEY_V:
        return ask(RoomAction::review, screen.status().source == ScreenSource::loop ? 0 : 1);
    case GLFW_KEY_COMMA:
        return step_frame(screen, -1);
    case GLFW_KEY_PERIOD:
        return step_frame(screen, 1);
    case GLFW_KEY_RIGHT:
    case GLFW_KEY_LEFT:
        if (is_control_down_) shift_mask(screen, key == GLFW_KEY_RIGHT ? shift_step_px : -shift_step_px, 0.0);
        break;
    case GLFW_KEY_UP:
    case GLFW_KEY_DOWN:
        if (is_control_down_) shift_mask(screen, 0.0, key == GLFW_KEY_UP ? shift_step_px : -shift_step_px);
        break;
    default:
        break;
    }
}

void WindowKeys::take_switch(int key)
{
    switch (key) {
    case GLFW_KEY_1:
    case GLFW_KEY_2:
    case GLFW_KEY_3:
        choose(static_cast<std::size_t>(key - GLFW_KEY_1));
        break;
    case GLFW_KEY_TAB:
        choose((chosen_tool_ + 1) % tool_count_);
        break;
    case GLFW_KEY_G:
        moves_all_ = tool_count_ > 1 && !moves_all_;
        break;
    case GLFW_KEY_Y:
        injection_rate_ = (injection_rate_ + 1) % std::size(injection_rates_ul_s);
        break;
    case GLFW_KEY_9:
        ask(RoomAction::load_stent);
        break;
    case GLFW_KEY_F:
        is_pedal_latched_ = !is_pedal_latched_;
        break;
    case GLFW_KEY_H:
    case GLFW_KEY_F1:
        shows_help_ = !shows_help_;
        break;
    case GLFW_KEY_R:
        wants_reset_ = true;
        break;
    case GLFW_KEY_ESCAPE:
        wants_end_ = true;
        break;
    default:
        break;
    }
}

void WindowKeys::take_rhythm(int key)
{
    const auto order = [&](std::uint8_t action, int value) {
        orders_.push_back(crn_wire_order_of_rhythm({action, static_cast<std::uint16_t>(value)}));
    };
    switch (key) {
    case GLFW_KEY_4:
    case GLFW_KEY_5:
        heart_rate_per_min_ = std::clamp(heart_rate_per_min_ + (key == GLFW_KEY_5 ? 10 : -10), 40, 160);
        return order(CRN_WIRE_RHYTHM_HEART_RATE, heart_rate_per_min_);
    case GLFW_KEY_6:
        return order(CRN_WIRE_RHYTHM_PREMATURE, premature_usual_milli);
    case GLFW_KEY_7:
        is_asystole_ = !is_asystole_;
        return order(CRN_WIRE_RHYTHM_ASYSTOLE, is_asystole_);
    case GLFW_KEY_8:
        holds_breath_ = !holds_breath_;
        return order(CRN_WIRE_RHYTHM_BREATH_HOLD, holds_breath_);
    default:
        break;
    }
}

// While the window does not have the keyboard focus, every key counts as released, because a window that
// loses the focus during a push must not continue to push.
void WindowKeys::hold(const Screen &screen)
{
    auto difference = [&](int plus, int minus) {
        return static_cast<std::int64_t>(screen.is_down(plus)) -
               static_cast<std::int64_t>(screen.is_down(minus));
    };
    is_control_down_ = screen.is_down(GLFW_KEY_LEFT_CONTROL) || screen.is_down(GLFW_KEY_RIGHT_CONTROL);
    is_shift_down_ = screen.is_down(GLFW_KEY_LEFT_SHIFT) || screen.is_down(GLFW_KEY_RIGHT_SHIFT);
    const std::int64_t moves = is_control_down_ ? 0 : 1; // with Ctrl the arrows move the mask
    push_um_per_s_ = moves * difference(GLFW_KEY_UP, GLFW_KEY_DOWN) *
                     (is_shift_down_ ? push_slow_um_per_s : push_um_per_s);
    turn_counts_per_s_ = moves * difference(GLFW_KEY_RIGHT, GLFW_KEY_LEFT) *
                         (is_shift_down_ ? turn_slow_counts_per_s : turn_counts_per_second);
    is_pedal_down_ = screen.is_down(GLFW_KEY_SPACE);
    is_cine_down_ = screen.is_down(GLFW_KEY_C);
    is_injecting_ = screen.is_down(GLFW_KEY_E);
    inflation_kPa_per_s_ = !screen.is_down(GLFW_KEY_U) ? 0 : (is_shift_down_ ? -400 : 100);
}

void WindowKeys::lead(std::span<LiveHand> hands) const
{
    for (std::size_t k = 0; k < hands.size(); ++k) {
        const bool is_led = moves_all_ || k == chosen_tool_;
        hands[k].set_speed(is_led ? push_um_per_s_ * counts_per_m / 1'000'000 : 0,
                           is_led ? turn_counts_per_s_ : 0);
    }
}

void WindowKeys::choose(std::size_t tool)
{
    if (tool >= tool_count_) return;
    chosen_tool_ = tool;
    moves_all_ = false;
}

std::vector<RoomCommand> WindowKeys::take_commands()
{
    const bool is_fluoro_asked = is_pedal_down_ || is_pedal_latched_;
    if (is_fluoro_asked != was_fluoro_asked_) ask(RoomAction::fluoro_pedal, is_fluoro_asked ? 1 : 0);
    if (is_cine_down_ != was_cine_asked_) ask(RoomAction::acquire_pedal, is_cine_down_ ? 1 : 0);
    was_fluoro_asked_ = is_fluoro_asked;
    was_cine_asked_ = is_cine_down_;
    if (is_injecting_ != was_injecting_)
        ask(RoomAction::inject, is_injecting_ ? inject_max_ul : 0, injection_rates_ul_s[injection_rate_]);
    was_injecting_ = is_injecting_;
    return std::exchange(commands_, {});
}

bool WindowKeys::take_reset()
{
    const bool wanted = wants_reset_;
    wants_reset_ = false;
    if (wanted)
        was_fluoro_asked_ = was_cine_asked_ = was_injecting_ = false; // in the new room all pedals are up
    if (wanted) {
        heart_rate_per_min_ = 70;
        is_asystole_ = holds_breath_ = false;
        orders_.clear();
    }
    return wanted;
}

// --- geometry: steps from the motors' targets ---

void WindowKeys::turn(const RoomScreen &screen, double primary_deg, double secondary_deg)
{
    const GantryPose &target = screen.room().gantry().target();
    ask(RoomAction::angles,
        std::clamp(rounded((target[axis_primary] + primary_deg) * 1e3), -primary_max_mdeg, primary_max_mdeg),
        std::clamp(rounded((target[axis_secondary] + secondary_deg) * 1e3), -secondary_max_mdeg,
                   secondary_max_mdeg));
}

// When the user moves the table by key, the table stops following the tip.
void WindowKeys::move_table(const RoomScreen &screen, int axis, double step_m)
{
    GantryPose target = screen.room().gantry().target();
    target[static_cast<std::size_t>(axis)] += step_m;
    std::int32_t place_um[3];
    for (int i = 0; i < 3; ++i)
        place_um[i] = std::clamp(rounded(target[static_cast<std::size_t>(axis_table_x + i)] * 1e6),
                                 -table_max_um, table_max_um);
    ask(RoomAction::table, place_um[0], place_um[1], place_um[2]);
}

void WindowKeys::change_distance(const RoomScreen &screen, double step_m)
{
    const GantryPose &target = screen.room().gantry().target();
    ask(RoomAction::distance, std::clamp(rounded((target[axis_sid] + step_m) * 1e6), sid_min_um, sid_max_um),
        std::clamp(rounded(target[axis_sod] * 1e6), sod_min_um, sod_max_um));
}

void WindowKeys::change_field(const RoomScreen &screen, int steps)
{
    const std::int32_t present_um = rounded(screen.room().field_m() * 1e6);
    const auto *at = std::find(std::begin(fields_um), std::end(fields_um), present_um);
    const int index = at == std::end(fields_um) ? 1 : static_cast<int>(at - std::begin(fields_um));
    ask(RoomAction::field,
        fields_um[std::clamp(index + steps, 0, static_cast<int>(std::size(fields_um)) - 1)]);
}

void WindowKeys::go_to(std::size_t preset)
{
    if (preset >= std::size(preset_keys)) return;
    const PresetKey &key = preset_keys[preset];
    const ViewPreset *view = view_preset(is_shift_down_ && !key.shifted.empty() ? key.shifted : key.plain);
    if (!view) return;
    ask(RoomAction::distance, view->sid_um, 750'000);
    ask(RoomAction::angles, view->primary_mdeg, view->secondary_mdeg);
    ask(RoomAction::field, view->field_um);
}

// --- review ---

// Steps from the displayed frame to the frame before or after it and shows that frame as a still picture,
// even if the screen shows a held picture or a loop.
void WindowKeys::step_frame(const RoomScreen &screen, int step)
{
    const RoomStatus status = screen.status();
    if (status.frames == 0) return ask(RoomAction::review, 2); // the last run's first frame, or the notice
    ask(RoomAction::review, 2, status.run, (status.frame + step + status.frames) % status.frames);
}

void WindowKeys::shift_mask(const RoomScreen &screen, double right_px, double up_px)
{
    const RoomStatus status = screen.status();
    const auto held = [](double pixels) {
        return std::clamp(rounded(pixels * 100.0), -shift_max_centipixels, shift_max_centipixels);
    };
    ask(RoomAction::shift, held(status.shift_right_px + right_px), held(status.shift_up_px + up_px));
}

} // namespace crn
