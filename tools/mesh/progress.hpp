// Reports the progress of long calculations on standard error, if that is a terminal, and handles the user's
// interrupt (Ctrl-C). Calculations that take less than a second print nothing.
#pragma once
#include "host/base/progress_line.hpp"
#include <chrono>
#include <cstddef>
#include <string>

namespace crn::bake
{

class Progress
{
  public:
    // After a call of this function, Ctrl-C or SIGTERM makes the function `step` throw a Fault, so that
    // destructors remove unfinished results. A second signal (Ctrl-C or SIGTERM) ends the program
    // immediately.
    static void catch_interrupts();
    static bool interrupted();

    // Begins a stage of a calculation with `total` steps; a `total` of 0 means that the number of steps is
    // unknown.
    void stage(const std::string &name, std::size_t total);
    // Reports that `done` steps of the present stage are complete. Throws Fault when the user has interrupted
    // the program.
    void step(std::size_t done);
    void finish();

  private:
    std::string name_;
    std::size_t total_ = 0;
    std::chrono::steady_clock::time_point began_, shown_;
    bool visible_ = false;
    const bool is_shown_ = shows_progress();
};

} // namespace crn::bake
