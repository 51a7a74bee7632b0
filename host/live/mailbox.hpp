// Passes the newest of a series of immutable values from one thread to another. If nobody has taken a value,
// the next value replaces it, so neither thread ever waits for the other.
//
//   Mailbox<Picture> pictures;
//   pictures.put(std::make_shared<const Picture>(...));     in the thread that makes them
//   if (auto picture = pictures.latest()) ...               in the thread that shows them
#pragma once
#include <memory>
#include <mutex>
#include <utility>

namespace crn
{

template <class T> class Mailbox
{
  public:
    void put(std::shared_ptr<const T> value)
    {
        const std::lock_guard lock(mutex_);
        slot_.swap(value); // the old value is destroyed outside the lock
    }
    // Returns the value that was stored last, or null if no value has been stored yet.
    std::shared_ptr<const T> latest() const
    {
        const std::lock_guard lock(mutex_);
        return slot_;
    }

  private:
    mutable std::mutex mutex_;
    std::shared_ptr<const T> slot_;
};

} // namespace crn
