#include "host/base/progress_line.hpp"
#include "host/base/terminal.hpp"
#include <algorithm>
#include <cstdio>
#include <unistd.h>

namespace crn
{

namespace
{

constexpr int bar_marks = 20;

} // namespace

bool shows_progress()
{
    return isatty(STDERR_FILENO) != 0;
}

ProgressLine::ProgressLine(bool is_wanted) : is_wanted_(is_wanted && shows_progress()) {}

ProgressLine::~ProgressLine()
{
    if (is_drawn_) std::fprintf(stderr, "\r\x1b[K");
}

void ProgressLine::show(const std::string &what, std::size_t done, std::size_t total)
{
    if (!is_wanted_) return;
    const bool is_new = what != begun_;
    begun_ = what;
    const Clock::time_point now = Clock::now();
    if (!is_new && now - drawn_at_ < std::chrono::milliseconds(100)) return;
    drawn_at_ = now;
    is_drawn_ = true;
    const double share =
        total > 0 ? std::min(1.0, static_cast<double>(done) / static_cast<double>(total)) : 0.0;
    std::string bar(static_cast<std::size_t>(share * bar_marks), '#');
    bar.resize(bar_marks, '-');
    std::fprintf(stderr, "\r\x1b[K%s  [%s] %3.0f %%", printable(what).c_str(), bar.c_str(), share * 100);
}

} // namespace crn
