#include "host/link/patience.hpp"
#include "host/base/interrupt.hpp"
#include <algorithm>

namespace crn
{

Patience::Span Patience::since(Clock::time_point begin) const
{
    return std::chrono::duration_cast<Span>(Clock::now() - begin);
}

void Patience::begin(Span more)
{
    more_ = more;
    begin_ = Clock::now();
}

void Patience::take(Span span)
{
    left_ = std::max(left_ - span, Span{0});
}

void Patience::end()
{
    const Span waited = since(begin_);
    if (is_short_)
        take(waited);
    else if (waited > free + more_)
        take(waited - free - more_);
    else
        left_ = std::min(left_ + regained, budget_);
}

void Patience::give_up()
{
    take(since(begin_));
}

bool Patience::is_over()
{
    if (is_interrupted() && !is_short_) {
        is_short_ = true;
        begin_ = Clock::now(); // the time that the host waited earlier is not counted
        left_ = std::min(left_, after_interrupt);
    }
    if (is_short_) return since(begin_) >= left_;
    return since(begin_) > left_ + free + more_;
}

Patience::Span Patience::spent() const
{
    return budget_ - left_;
}

} // namespace crn
