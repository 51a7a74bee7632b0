// Defines the meaning of the window's keys: one table determines both their actions and the text of the help
// panel.
#pragma once
#include "host/room/room_screen.hpp"
#include "host/screen/screen.hpp"
#include "host/script/hand_motion.hpp"
#include "host/script/rhythm.hpp"
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace crn
{

class WindowKeys
{
  public:
    WindowKeys(std::size_t tool_count, bool shows_help) : tool_count_(tool_count), shows_help_(shows_help) {}

    // Handles the keys that move the C-arm and the table, change the size of the X-ray field, and switch
    // functions on or off. Most keys change the present state of the X-ray room, which the function reads
    // from `screen`.
    void take(const Screen::KeyEvent &event, const RoomScreen &screen);
    void hold(const Screen &screen); // handles keys held down: hand and pedal; call once per screen
    void
    lead(std::span<LiveHand> hands) const; // the demanded speeds; hands that are not selected come to rest

    // The next two functions return which tool the user moves with the keys (counted from the innermost), and
    // whether these keys move all tools together.
    std::size_t chosen_tool() const { return chosen_tool_; }
    bool moves_all() const { return moves_all_; }

    // Returns the rate in kPa/s at which the keys raise or release the inflator's pressure.
    std::int32_t inflation_kPa_per_s() const { return inflation_kPa_per_s_; }

    // Returns the commands for the X-ray room since the last call, including those of the pedals.
    std::vector<RoomCommand> take_commands();
    // Returns the user's commands for the simulated heartbeat and breathing since the last call.
    std::vector<crn_wire_order> take_orders() { return std::exchange(orders_, {}); }
    bool shows_help() const { return shows_help_; }
    bool wants_end() const { return wants_end_; }
    bool take_reset(); // true once after the key R
    void latch_pedal() { is_pedal_latched_ = true; }

  private:
    void take_geometry(int key, const RoomScreen &screen);
    void take_collimator(int key, const RoomScreen &screen);
    void take_mode(int key, const RoomScreen &screen);
    void take_review(int key, const RoomScreen &screen);
    void take_switch(int key);
    void take_rhythm(int key);
    void turn(const RoomScreen &screen, double primary_deg, double secondary_deg);
    void move_table(const RoomScreen &screen, int axis, double step_m);
    void change_distance(const RoomScreen &screen, double step_m);
    void change_field(const RoomScreen &screen, int steps);
    void go_to(std::size_t preset);
    void step_frame(const RoomScreen &screen, int step);
    void shift_mask(const RoomScreen &screen, double right_px, double up_px);
    void ask(RoomAction action, std::int32_t a = 0, std::int32_t b = 0, std::int32_t c = 0);
    void choose(std::size_t tool);

    std::size_t tool_count_, chosen_tool_ = 0;
    bool moves_all_ = false;
    std::vector<RoomCommand> commands_;
    std::vector<crn_wire_order> orders_;
    int heart_rate_per_min_ = 70; // as at the core's start
    bool is_asystole_ = false, holds_breath_ = false;
    bool shows_help_, is_control_down_ = false, is_shift_down_ = false;
    bool wants_end_ = false, wants_reset_ = false;
    bool is_pedal_down_ = false, is_pedal_latched_ = false, is_cine_down_ = false;
    bool was_fluoro_asked_ = false, was_cine_asked_ = false;
    std::int32_t inflation_kPa_per_s_ = 0;
    bool is_injecting_ = false, was_injecting_ = false;
    std::size_t injection_rate_ = 2; // index
    std::int64_t push_um_per_s_ = 0, turn_counts_per_s_ = 0;
};

std::vector<std::string> help_panel(std::size_t tool_count);

} // namespace crn
