// While the host is busy with a picture, another thread sends messages to the rig, so that the host counts as
// alive. Without these messages the forces in the hand would fade with every picture that takes longer than
// 30 ms. The messages end after half a second, because a host that hangs must not count as alive. Nothing
// else may use the link while an object of this class exists.
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

    explicit Presence(Link *link); // nullptr: there is no rig to inform
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
