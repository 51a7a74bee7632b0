// Sends messages to the rig from another thread while the host computes a picture, so that the rig knows that
// the host is alive. Without messages from the host, the force that the hand feels would fade during every
// picture that takes longer than 30 ms. The thread sends no more messages after half a second, because the
// rig must notice when the host no longer responds. No other code may use the link while an object of this
// class exists.
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
