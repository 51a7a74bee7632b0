// Holds the messages that wait to be sent, grouped by moments of the session, in bounded memory. Each moment
// has at most one value for each message name. If too many moments wait, the oldest one is dropped. If only
// the dropped moment had a value for a name, the next moment gets this value, so the newest value of every
// name is always sent.
#pragma once
#include <cstddef>
#include <deque>
#include <map>
#include <string>
#include <utility>

namespace crn
{

template <class Value> class Outbox
{
  public:
    using Moment = std::map<std::string, Value>;
    static constexpr std::size_t moments_max = 8;

    void push(Moment moment)
    {
        moments_.push_back(std::move(moment));
        if (moments_.size() <= moments_max) return;
        moments_[1].merge(moments_[0]); // keeps the newer values
        moments_.pop_front();
        ++dropped_;
    }
    bool is_empty() const { return moments_.empty(); }
    std::size_t size() const { return moments_.size(); }
    Moment pop()
    {
        Moment first = std::move(moments_.front());
        moments_.pop_front();
        return first;
    }
    std::size_t dropped() const { return dropped_; }

  private:
    std::deque<Moment> moments_;
    std::size_t dropped_ = 0;
};

} // namespace crn
