// How long a device may keep its host waiting, all waits of a conversation together. An honest one answers
// within milliseconds. What a wait takes beyond `free` is taken from the budget, and every quick answer gives
// a little back: so a device that is silent, that talks without answering, or that answers each request a
// little before some limit ends in the same bounded time. From Ctrl-C on there is only what a healthy device
// needs for a clean end.
#pragma once
#include <chrono>
#include <cstdint>

namespace crn
{

class Patience
{
  public:
    using Clock = std::chrono::steady_clock;
    using Span = std::chrono::milliseconds;
    // What an honest device needs at most for an answer, and for each tick that it is asked for (a rig: 1 ms;
    // its image in an emulator beside other work: 3 ms). The budget is for a scene's check, the longest
    // single wait, once or twice.
    static constexpr Span free{200}, free_per_tick{5}, budget_default{3500}, regained{2},
        after_interrupt{400};

    explicit Patience(Span budget = budget_default) : budget_(budget), left_(budget) {}

    void begin(Span more = Span{0}); // a wait begins; `more` is free as well
    void end();                      // it ended with what was waited for
    bool is_over();                  // also by Ctrl-C
    void give_up();                  // the wait ended without: all of it counts
    Span spent() const; // beyond what is free, since the conversation began, less what was regained

  private:
    Span since(Clock::time_point begin) const;
    void take(Span span);

    Span budget_, left_, more_{0};
    bool is_short_ = false; // of an interrupt
    Clock::time_point begin_{};
};

} // namespace crn
