// Progress of long work on standard error, and the wish to stop (Ctrl-C). Silent for work that takes less
// than a second.
#pragma once
#include <chrono>
#include <cstddef>
#include <string>

namespace crn::bake
{

class Progress
{
  public:
    // From now on Ctrl-C and SIGTERM make `step` throw a Fault, so that everything half done is undone on the
    // way out; the second one ends the program.
    static void catch_interrupts();
    static bool interrupted();

    // Begin a stage of `total` steps (0: unknown).
    void stage(const std::string &name, std::size_t total);
    // So many steps are done. Throws Fault when the user interrupted.
    void step(std::size_t done);
    void finish();

  private:
    std::string name_;
    std::size_t total_ = 0;
    std::chrono::steady_clock::time_point began_, shown_;
    bool visible_ = false;
};

} // namespace crn::bake
