// Shows the progress of long work on standard error output, if that is a terminal. The progress is never
// written to a file or a pipe.
#pragma once
#include <chrono>
#include <cstddef>
#include <string>

namespace crn
{

// Returns true if standard error output is a terminal. No program prints progress elsewhere.
bool shows_progress();

class ProgressLine
{
  public:
    // If `is_wanted` is false, nothing is printed.
    explicit ProgressLine(bool is_wanted);
    ~ProgressLine(); // erases the bar
    ProgressLine(const ProgressLine &) = delete;
    ProgressLine &operator=(const ProgressLine &) = delete;

    // Shows a line such as "writing out/dicom/run_01.dcm (1 of 3) [#####-----] 52 %", at most ten times a
    // second.
    void show(const std::string &what, std::size_t done, std::size_t total);

  private:
    using Clock = std::chrono::steady_clock;
    bool is_wanted_;
    bool is_drawn_ = false;
    std::string begun_;
    Clock::time_point drawn_at_{};
};

} // namespace crn
