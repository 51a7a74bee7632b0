// Reports progress of long work on standard error and handles the user's interrupt (Ctrl-C). Nothing is
// printed for work that takes less than a second.
#pragma once
#include <chrono>
#include <cstddef>
#include <string>

namespace crn::bake
{

class Progress
{
  public:
    // After this call, Ctrl-C and SIGTERM make `step` throw a Fault, so that unfinished work is undone while
    // the stack unwinds. A second signal ends the program immediately.
    static void catch_interrupts();
    static bool interrupted();

    // Begins a stage of `total` steps; 0 means that the number is unknown.
    void stage(const std::string &name, std::size_t total);
    // Reports that `done` steps are complete. Throws Fault when the user has interrupted the program.
    void step(std::size_t done);
    void finish();

  private:
    std::string name_;
    std::size_t total_ = 0;
    std::chrono::steady_clock::time_point began_, shown_;
    bool visible_ = false;
};

} // namespace crn::bake
