// Converts the state of a gamepad to controls: buttons by the table of controls, the right stick pushes, the
// left stick turns, and the triggers are the pedals.
#pragma once
#include "host/suite/user_input.hpp"
#include <array>

namespace crn
{

struct GamepadState {
    std::array<bool, 15> buttons{}; // index: GLFW_GAMEPAD_BUTTON_*
    std::array<float, 6> axes{};    // index: GLFW_GAMEPAD_AXIS_*; sticks down and right +1; triggers -1 .. 1
};

class Gamepad
{
  public:
    // Passes on what has changed on the gamepad since the last call. Without a gamepad, `state` is null, and
    // every control that the gamepad held is released.
    void take(const GamepadState *state, UserInput &input);

    static constexpr float dead_zone = 0.18f;
    // A trigger presses its pedal above the value trigger_on, and releases it below trigger_off.
    static constexpr float trigger_on = 0.2f, trigger_off = -0.2f;

  private:
    void trigger(float value, bool &is_down, ControlId id, UserInput &input);

    GamepadState last_;
    bool is_fluoro_ = false, is_acquire_ = false, was_moving_ = false;
};

// Reads the first gamepad with a known mapping. Returns false if no gamepad has a known mapping.
bool read_gamepad(GamepadState &state);

} // namespace crn
