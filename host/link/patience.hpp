// Limits how long a device may keep the host waiting in total, over a whole conversation. A correct device
// answers each request within milliseconds. If a wait exceeds the time `free`, the excess is subtracted from
// the time budget; every quick answer returns a little time to the budget. The host therefore gives up after
// the same bounded time, whether a device is silent, sends without answering, or answers each request just
// before a time limit. After Ctrl-C the host waits only as long as a healthy device needs to end a session
// cleanly.
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
    // `free` is the longest time that a correct device needs for an answer, and `free_per_tick` is the
    // longest time that it needs for each requested tick. A rig needs 1 ms for each tick. The rig's firmware
    // in an emulator needs 3 ms per tick on a computer that also does other work. The time budget is enough
    // for one or two checks of a scene, which are the longest single waits.
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
