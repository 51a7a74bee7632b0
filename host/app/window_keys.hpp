// What the keys of the window mean: one table for the handling and the help panel.
// May include: view_state, window_screen. Called by: window.
#pragma once
#include "host/app/hand_motion.hpp"
#include "host/app/view_state.hpp"
#include "host/app/window_screen.hpp"
#include <span>
#include <string>
#include <vector>

namespace seld
{

class WindowKeys
{
  public:
    WindowKeys(const ViewState &view, std::size_t tool_count, bool shows_help)
        : tool_count_(tool_count), view_(view), shows_help_(shows_help)
    {
    }

    void take(const Screen::KeyEvent &event); // presses: C-arm, table, field, switches
    void hold(const Screen &screen);          // keys held down: hand and pedal; call once per screen
    void
    lead(std::span<LiveHand> hands) const; // the speeds asked for; hands that are not chosen come to rest

    // The tool that the hand keys move, from the innermost, and whether they move all.
    std::size_t chosen_tool() const { return chosen_tool_; }
    bool moves_all() const { return moves_all_; }

    ViewState view() const; // what the C-arm is asked for now
    bool shows_help() const { return shows_help_; }
    bool wants_end() const { return wants_end_; }
    bool take_reset(); // true once after R
    void latch_pedal() { is_pedal_latched_ = true; }

  private:
    void change_field(int steps);
    void move_table(int axis, int direction);
    void choose(std::size_t tool);

    std::size_t tool_count_, chosen_tool_ = 0;
    bool moves_all_ = false;
    ViewState view_;
    bool shows_help_;
    bool wants_end_ = false, wants_reset_ = false;
    bool is_pedal_down_ = false, is_pedal_latched_ = false;
    std::int64_t push_um_per_s_ = 0, turn_counts_per_s_ = 0;
};

std::vector<std::string> help_panel(std::size_t tool_count);

} // namespace seld
