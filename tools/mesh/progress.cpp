// Progress lines and interruption.
#include "tools/mesh/progress.hpp"
#include "host/base/guarded_read.hpp"
#include "host/base/interrupt.hpp"
#include "tools/mesh/fault.hpp"

#include <cstdio>

namespace crn::bake
{

void Progress::catch_interrupts()
{
    watch_for_interrupt();
    stop_reading_when(interrupted);
}

bool Progress::interrupted()
{
    return is_interrupted();
}

void Progress::stage(const std::string &name, std::size_t total)
{
    finish();
    name_ = name;
    total_ = total;
    began_ = shown_ = std::chrono::steady_clock::now();
    step(0);
}

void Progress::step(std::size_t done)
{
    using namespace std::chrono_literals;
    if (interrupted()) throw Fault("interrupted: nothing was written");
    const auto now = std::chrono::steady_clock::now();
    if (!is_shown_ || now - began_ < 1s || now - shown_ < 500ms) return;
    shown_ = now;
    visible_ = true;
    if (total_ > 0)
        std::fprintf(stderr, "\r%s: %3.0f %%", name_.c_str(),
                     100.0 * static_cast<double>(done) / static_cast<double>(total_));
    else
        std::fprintf(stderr, "\r%s ...", name_.c_str());
    std::fflush(stderr);
}

void Progress::finish()
{
    if (visible_) std::fprintf(stderr, "\r%s: done \n", name_.c_str());
    visible_ = false;
}

} // namespace crn::bake
