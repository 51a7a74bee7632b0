// Collects the user's actions with keys, mouse, gamepad and foot pedals, and converts them to actions of the
// session. A control that is pressed and released between two calls of take() still acts once. A control may
// be held by several inputs at once, such as a key and a button on the screen.
#pragma once
#include "host/live/hand_speed.hpp"
#include "host/model/tool_line.hpp"
#include "host/suite/controls.hpp"
#include <array>
#include <map>
#include <optional>
#include <vector>

namespace crn
{

// Holds the user's actions since the last call of UserInput::take().
struct UserWishes {
    std::vector<ControlId> actions; // whose commands depend on the room: commands_of()
    std::vector<RoomCommand> commands;
    std::vector<crn_wire_order> orders;
    std::vector<HandSpeed> hands; // one per tool; empty: unchanged
    std::optional<std::int32_t> inflation_kPa_per_s;
    bool is_any() const
    {
        return !actions.empty() || !commands.empty() || !orders.empty() || !hands.empty() ||
               inflation_kPa_per_s;
    }
};

class UserInput
{
  public:
    explicit UserInput(std::size_t tool_count) : tool_count_(tool_count) {}

    // Receives an event of GLFW's key callback: GLFW_KEY_*, GLFW_PRESS, GLFW_REPEAT or GLFW_RELEASE, and
    // GLFW_MOD_*.
    void key(int key, int action, int modifiers);
    void press(ControlId id);
    void repeat(ControlId id);
    void release(ControlId id);
    // Releases everything. A window that loses the keyboard focus calls this function, because it receives no
    // later release of keys.
    void release_all();
    // Sets the sticks of a gamepad, -1 .. 1: at full deflection a stick moves the tool as fast as a key does.
    void analog(double push, double turn);
    void choose(std::size_t tool);
    // Receives which tools of the table are in use now; the other tools of the table can be loaded.
    void see_line(const LineNumbers &line, std::size_t table_count);
    // Selects the tool that is to be loaded, by its number in the table.
    void select_to_load(std::uint8_t number);
    std::uint8_t to_load() const { return to_load_; } // 0: every tool of the table is on the line
    void latch_pedal() { is_latched_ = true; }

    UserWishes take();
    // Call this function when a new session begins: all its pedals are up, and the heart beats at its own
    // rate. Pedals that are still held when a session begins are pressed again.
    void begin_session();

    std::size_t chosen_tool() const { return chosen_tool_; }
    bool moves_all() const { return moves_all_; }
    bool is_latched() const { return is_latched_; }
    double injection_ml_s() const;
    bool is_held(ControlId id) const { return held_[static_cast<std::size_t>(id)] > 0; }
    // Returns the controls of the window itself (such as help and end) that were used since the last call of
    // take_own().
    std::vector<ControlId> take_own() { return std::exchange(own_, {}); }

  private:
    void act(ControlId id);
    bool act_on_tools(ControlId id);
    bool act_on_heart(ControlId id);
    bool act_on_rack(ControlId id);
    bool is_on_line(std::size_t number) const;
    void step_to_load(std::size_t step);
    void add_pedals(UserWishes &wishes);
    std::vector<HandSpeed> hand_speeds() const;

    std::size_t tool_count_, chosen_tool_ = 0;
    LineNumbers line_;
    std::size_t table_count_ = 0;
    std::uint8_t to_load_ = 0; // number in the table
    bool moves_all_ = false, is_latched_ = false, is_slow_ = false;
    double push_stick_ = 0.0, turn_stick_ = 0.0;
    std::array<int, control_count> held_{}, to_release_{};
    std::array<bool, control_count> is_fresh_{}; // pressed since the last take()
    std::map<int, ControlId> keys_;              // that are down, and what they began
    std::vector<ControlId> actions_, own_;
    std::vector<RoomCommand> commands_;
    std::vector<crn_wire_order> orders_;
    std::vector<HandSpeed> last_hands_;
    std::int32_t last_inflation_ = 0;
    bool was_fluoro_ = false, was_acquire_ = false, was_injecting_ = false;
    std::size_t injection_rate_ = 2; // index
    int heart_rate_per_min_ = 70;    // as at the core's start
    bool is_asystole_ = false, holds_breath_ = false;
};

} // namespace crn
