// Limits how long a device may keep its host waiting, over all waits of a conversation together. A correct
// device answers within milliseconds. Waiting beyond `free` is taken from the budget, and every quick answer
// returns a little. So a device ends in the same bounded time if it is silent, sends without answering, or
// answers each request just before some limit. After Ctrl-C only as much time remains as a healthy device
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
    // The longest time that a correct device needs for an answer, and for each requested tick (a rig: 1 ms;
    // its image in an emulator beside other work: 3 ms). The budget allows a scene's check, the longest
    // single wait, once or twice.
    static constexpr Span free{200}, free_per_tick{5}, budget_default{3500}, regained{2},
        after_interrupt{400};

    explicit Patience(Span budget = budget_default) : budget_(budget), left_(budget) {}

    void begin(Span more = Span{0}); // a wait begins; `more` is free as well
    void end();                      // the wait ended with the expected answer
    bool is_over();                  // also after Ctrl-C
    void give_up();                  // the wait ended without an answer: all of it counts
    Span spent() const; // waiting time beyond the free part since the conversation began, less what quick
                        // answers returned

  private:
    Span since(Clock::time_point begin) const;
    void take(Span span);

    Span budget_, left_, more_{0};
    bool is_short_ = false; // shortened by an interrupt
    Clock::time_point begin_{};
};

} // namespace crn
