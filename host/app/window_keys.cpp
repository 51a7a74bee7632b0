#include "host/app/window_keys.hpp"
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>
#include <iterator>

namespace seld
{
namespace
{

constexpr std::int64_t push_um_per_s = 30'000, push_slow_um_per_s = 6'000;
constexpr std::int64_t turn_counts_per_second = counts_per_turn / 2,
                       turn_slow_counts_per_s = counts_per_turn / 12;
constexpr std::int32_t angle_step_mdeg = 5'000, primary_max_mdeg = 120'000, secondary_max_mdeg = 50'000;
constexpr std::int32_t table_step_um = 20'000, table_max_um = 1'500'000;
constexpr std::int32_t fields_um[] = {420'000, 320'000, 250'000, 200'000, 150'000};

void step_angle(std::int32_t &angle_mdeg, std::int32_t step_mdeg, std::int32_t max_mdeg)
{
    angle_mdeg = std::clamp(angle_mdeg + step_mdeg, -max_mdeg, max_mdeg);
}

} // namespace

std::vector<std::string> help_panel(std::size_t tool_count)
{
    std::vector<std::string> lines = {"KEYS                      H or F1 hides this",
                                      "",
                                      "Up / Down       push / pull the tool",
                                      "Left / Right    turn it      (Shift: slowly)",
                                      "Space (hold)    X-ray pedal",
                                      "F               X-ray stays on / off",
                                      "",
                                      "D / A           C-arm to LAO / RAO",
                                      "W / S           C-arm to CRA / CAU",
                                      "0               back to AP",
                                      "+ / -           smaller / larger field",
                                      "I K J L         table: head feet right left",
                                      "T               follow the tip on / off",
                                      "",
                                      "R  start again                    Esc  end"};
    if (tool_count > 1) {
        const std::string numbers = tool_count == 2 ? "1 2 or Tab      " : "1 2 3 or Tab    ";
        lines.insert(lines.begin() + 2, {numbers + "choose the tool, innermost first",
                                         "G               move all together on / off"});
    }
    return lines;
}

void WindowKeys::take(const Screen::KeyEvent &event)
{
    if (event.is_release) return;
    switch (event.key) {
    case GLFW_KEY_D:
        return step_angle(view_.primary_mdeg, angle_step_mdeg, primary_max_mdeg);
    case GLFW_KEY_A:
        return step_angle(view_.primary_mdeg, -angle_step_mdeg, primary_max_mdeg);
    case GLFW_KEY_W:
        return step_angle(view_.secondary_mdeg, angle_step_mdeg, secondary_max_mdeg);
    case GLFW_KEY_S:
        return step_angle(view_.secondary_mdeg, -angle_step_mdeg, secondary_max_mdeg);
    case GLFW_KEY_I:
        return move_table(1, 1);
    case GLFW_KEY_K:
        return move_table(1, -1);
    case GLFW_KEY_J:
        return move_table(0, -1);
    case GLFW_KEY_L:
        return move_table(0, 1);
    default:
        break;
    }
    if (!event.is_press) return; // the rest does not repeat
    switch (event.key) {
    case GLFW_KEY_1:
    case GLFW_KEY_2:
    case GLFW_KEY_3:
        choose(static_cast<std::size_t>(event.key - GLFW_KEY_1));
        break;
    case GLFW_KEY_TAB:
        choose((chosen_tool_ + 1) % tool_count_);
        break;
    case GLFW_KEY_G:
        moves_all_ = tool_count_ > 1 && !moves_all_;
        break;
    case GLFW_KEY_0:
    case GLFW_KEY_KP_0:
        view_.primary_mdeg = view_.secondary_mdeg = 0;
        break;
    case GLFW_KEY_EQUAL:
    case GLFW_KEY_KP_ADD:
        change_field(1);
        break;
    case GLFW_KEY_MINUS:
    case GLFW_KEY_KP_SUBTRACT:
        change_field(-1);
        break;
    case GLFW_KEY_F:
        is_pedal_latched_ = !is_pedal_latched_;
        break;
    case GLFW_KEY_T:
        view_.follows_tip = !view_.follows_tip;
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

// Without the focus no key is down: a window that loses it in mid-push must not go on pushing.
void WindowKeys::hold(const Screen &screen)
{
    auto difference = [&](int plus, int minus) {
        return static_cast<std::int64_t>(screen.is_down(plus)) -
               static_cast<std::int64_t>(screen.is_down(minus));
    };
    const bool is_slow = screen.is_down(GLFW_KEY_LEFT_SHIFT) || screen.is_down(GLFW_KEY_RIGHT_SHIFT);
    push_um_per_s_ = difference(GLFW_KEY_UP, GLFW_KEY_DOWN) * (is_slow ? push_slow_um_per_s : push_um_per_s);
    turn_counts_per_s_ = difference(GLFW_KEY_RIGHT, GLFW_KEY_LEFT) *
                         (is_slow ? turn_slow_counts_per_s : turn_counts_per_second);
    is_pedal_down_ = screen.is_down(GLFW_KEY_SPACE);
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

ViewState WindowKeys::view() const
{
    ViewState view = view_;
    view.is_fluoro_on = is_pedal_down_ || is_pedal_latched_;
    return view;
}

bool WindowKeys::take_reset()
{
    const bool wanted = wants_reset_;
    wants_reset_ = false;
    return wanted;
}

void WindowKeys::change_field(int steps)
{
    const auto *at = std::find(std::begin(fields_um), std::end(fields_um), view_.field_um);
    const int index = at == std::end(fields_um) ? 1 : static_cast<int>(at - std::begin(fields_um));
    view_.field_um = fields_um[std::clamp(index + steps, 0, static_cast<int>(std::size(fields_um)) - 1)];
}

// Moving the table by hand ends following the tip.
void WindowKeys::move_table(int axis, int direction)
{
    view_.follows_tip = false;
    std::int32_t &place_um = view_.table_um[axis];
    place_um = std::clamp(place_um + direction * table_step_um, -table_max_um, table_max_um);
}

} // namespace seld
