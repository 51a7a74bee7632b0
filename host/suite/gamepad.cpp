#include "host/suite/gamepad.hpp"
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

// Returns 0 while a stick is near its rest position; outside this zone the returned value rises from 0.
double stick(float value)
{
    const double size = std::fabs(value);
    if (size <= Gamepad::dead_zone) return 0.0;
    return std::copysign((std::min(size, 1.0) - Gamepad::dead_zone) / (1.0 - Gamepad::dead_zone), value);
}

} // namespace

void Gamepad::trigger(float value, bool &is_down, ControlId id, UserInput &input)
{
    if (!is_down && value > trigger_on) {
        is_down = true;
        input.press(id);
    } else if (is_down && value < trigger_off) {
        is_down = false;
        input.release(id);
    }
}

void Gamepad::take(const GamepadState *state, UserInput &input)
{
    GamepadState now;
    now.axes[GLFW_GAMEPAD_AXIS_LEFT_TRIGGER] = now.axes[GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER] = -1.0f;
    if (state) now = *state;
    for (std::size_t i = 0; i < now.buttons.size(); ++i) {
        const Control *found = control_of_pad(static_cast<int>(i));
        if (!found || now.buttons[i] == last_.buttons[i]) continue;
        if (now.buttons[i])
            input.press(found->id);
        else
            input.release(found->id);
    }
    trigger(now.axes[GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER], is_fluoro_, ControlId::fluoro, input);
    trigger(now.axes[GLFW_GAMEPAD_AXIS_LEFT_TRIGGER], is_acquire_, ControlId::acquire, input);
    const double push = -stick(now.axes[GLFW_GAMEPAD_AXIS_RIGHT_Y]),
                 turn = stick(now.axes[GLFW_GAMEPAD_AXIS_LEFT_X]);
    const bool is_moving = push != 0.0 || turn != 0.0;
    if (is_moving || was_moving_) input.analog(push, turn);
    was_moving_ = is_moving;
    last_ = now;
}

bool read_gamepad(GamepadState &state)
{
    for (int id = GLFW_JOYSTICK_1; id <= GLFW_JOYSTICK_LAST; ++id) {
        GLFWgamepadstate read;
        if (!glfwJoystickIsGamepad(id) || !glfwGetGamepadState(id, &read)) continue;
        for (std::size_t i = 0; i < state.buttons.size(); ++i)
            state.buttons[i] = read.buttons[i] == GLFW_PRESS;
        std::copy_n(read.axes, state.axes.size(), state.axes.begin());
        return true;
    }
    return false;
}

} // namespace crn
