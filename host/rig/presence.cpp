#include "host/rig/presence.hpp"

namespace crn
{

Presence::Presence(Link *link)
{
    if (link != nullptr) thread_ = std::thread([this, link] { say(*link); });
}

Presence::~Presence()
{
    if (!thread_.joinable()) return;
    {
        const std::lock_guard<std::mutex> hold(lock_);
        is_over_ = true;
    }
    over_.notify_all();
    thread_.join();
}

// The thread ignores errors, because the next function that uses the device also finds that the device is
// disconnected.
void Presence::say(Link &link)
{
    const auto end = std::chrono::steady_clock::now() + limit;
    std::unique_lock<std::mutex> hold(lock_);
    while (!over_.wait_for(hold, std::chrono::milliseconds(Link::heartbeat_ms), [this] {
        return is_over_;
    }) && std::chrono::steady_clock::now() < end) {
        try {
            link.say_present();
        } catch (const LinkError &) {
            return;
        }
    }
}

} // namespace crn
