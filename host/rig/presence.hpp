// A host that is busy with a picture is there all the same: the rig hears of it from another thread
// meanwhile, so that the forces in the hand do not fade with every picture that takes longer than 30 ms. For
// half a second at most: a host that hangs is none. Nobody else may use the link as long as such an object
// lives.
#pragma once
#include "host/link/link.hpp"
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace crn
{

class Presence
{
  public:
    static constexpr std::chrono::milliseconds limit{500};

    explicit Presence(Link *link); // nullptr: nobody has to be told
    ~Presence();
    Presence(const Presence &) = delete;
    Presence &operator=(const Presence &) = delete;

  private:
    void say(Link &link);

    std::mutex lock_;
    std::condition_variable over_;
    bool is_over_ = false;
    std::thread thread_;
};

} // namespace crn
