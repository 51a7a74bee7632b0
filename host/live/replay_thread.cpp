#include "host/live/replay_thread.hpp"
#include "host/live/thread_priority.hpp"
#include <chrono>

namespace crn
{

constexpr std::uint32_t track_ticks = 200; // between looks at the end

ReplayThread::ReplayThread(std::unique_ptr<ReplayRoom> room) : room_(std::move(room))
{
    track_ = std::thread([this] { prepare(); });
    pictures_ = std::thread([this] { draw(); });
}

ReplayThread::~ReplayThread()
{
    {
        const std::lock_guard lock(mutex_);
        must_end_ = true;
    }
    changed_.notify_all();
    track_.join();
    pictures_.join();
}

void ReplayThread::ask(const ReplayAsk &ask)
{
    {
        const std::lock_guard lock(mutex_);
        asked_ = ask;
    }
    changed_.notify_all();
}

void ReplayThread::prepare()
{
    yield_to_physics(10);
    try {
        for (bool goes_on = true; goes_on;) {
            {
                const std::lock_guard lock(mutex_);
                if (must_end_) return;
            }
            goes_on = room_->prepare(track_ticks);
        }
    } catch (const std::exception &) {
        // If the preparation fails, the pictures continue without medium and stents, and are marked as not
        // prepared.
    }
}

void ReplayThread::draw()
{
    std::uint64_t number = 0;
    for (;;) {
        ReplayAsk ask;
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [this] { return asked_ || must_end_; });
            if (must_end_) return;
            ask = *asked_;
            asked_.reset();
        }
        auto shown = std::make_shared<ReplayShown>();
        const auto begin = std::chrono::steady_clock::now();
        try {
            shown->picture = room_->picture(ask);
        } catch (const std::exception &error) {
            shown->trouble = error.what();
        }
        shown->number = ++number;
        shown->took_ms =
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
        shown_.put(std::move(shown));
    }
}

} // namespace crn
