#include "host/live/physics_thread.hpp"
#include <algorithm>
#include <array>

namespace crn
{
namespace
{

constexpr std::int64_t ticks_behind_max = 100; // farther behind real time than this, the session slows down
constexpr std::int64_t ticks_at_once_max = 16;
constexpr auto publish_every = std::chrono::milliseconds(20);
constexpr auto urgent_again_after = std::chrono::seconds(1);
constexpr auto late_after = std::chrono::milliseconds(2);

// Counts the ticks that are due, and measures how punctual they are. Tick n is due n ms after the beginning,
// plus the time by which the session has fallen behind.
class Pace
{
  public:
    SuiteClock::time_point time_of(std::int64_t tick) const
    {
        return begin_ + std::chrono::milliseconds(tick) + lost_;
    }
    std::int64_t ticks_due()
    {
        const auto now = SuiteClock::now();
        const std::int64_t due =
            std::chrono::duration_cast<std::chrono::milliseconds>(now - begin_ - lost_).count() - ticks_;
        if (due > ticks_behind_max) lose(now, std::chrono::milliseconds(due - ticks_behind_max));
        return std::clamp<std::int64_t>(due, 0, ticks_at_once_max);
    }
    void done(std::int64_t count)
    {
        const auto now = SuiteClock::now();
        for (std::int64_t i = 1; i <= count; ++i)
            if (now - time_of(ticks_ + i) > late_after) ++figures_.late_ticks;
        ticks_ += count;
    }
    std::int64_t next() const { return ticks_ + 1; }
    // Punctual threads are urgent. If a session cannot keep up with real time, it computes without a pause. A
    // session's thread then has ordinary priority until it has kept up for a second, so that it does not
    // block the GUI window.
    void choose_urgency()
    {
        const bool should_be_urgent = SuiteClock::now() - lost_at_ > urgent_again_after;
        if (should_be_urgent == is_urgent_) return;
        is_urgent_ = should_be_urgent;
        if (!is_urgent_) make_thread_ordinary();
        figures_.urgency = is_urgent_ ? make_thread_urgent() : ThreadUrgency::ordinary;
    }

    // Returns the figures about the physics' pace for the window. The real-time factor is computed over the
    // last second.
    const PaceFigures &figures()
    {
        const auto now = SuiteClock::now();
        figures_.ticks = static_cast<std::uint64_t>(ticks_);
        figures_.lost_s = std::chrono::duration<double>(lost_).count();
        marks_[mark_++ % marks_.size()] = {now, ticks_};
        const Mark oldest = mark_ < marks_.size() ? marks_[0] : marks_[mark_ % marks_.size()];
        const double seconds = std::chrono::duration<double>(now - oldest.when).count();
        if (seconds > 0.1)
            figures_.real_time_factor = static_cast<double>(ticks_ - oldest.ticks) * 1e-3 / seconds;
        return figures_;
    }

  private:
    void lose(SuiteClock::time_point now, SuiteClock::duration time)
    {
        lost_ += time;
        lost_at_ = now;
    }

    struct Mark {
        SuiteClock::time_point when;
        std::int64_t ticks = 0;
    };
    SuiteClock::time_point begin_ = SuiteClock::now();
    SuiteClock::duration lost_{};
    SuiteClock::time_point lost_at_{};
    bool is_urgent_ = false;
    std::int64_t ticks_ = 0;
    PaceFigures figures_;
    std::array<Mark, 50> marks_{}; // one per publication
    std::size_t mark_ = 0;
};

} // namespace

PhysicsThread::PhysicsThread(std::unique_ptr<LiveSession> session, PhysicsPace pace)
    : session_(std::move(session)), pictures_(session_->pictures()), pace_(pace)
{
    publish({});
    thread_ = std::thread([this] { run(); });
}

PhysicsThread::~PhysicsThread()
{
    {
        const Lock lock(mutex_);
        must_end_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
}

void PhysicsThread::run()
{
    try {
        if (pace_ == PhysicsPace::counted)
            run_counted();
        else
            run_in_real_time();
    } catch (...) {
        const Lock lock(mutex_);
        failure_ = std::current_exception();
        is_counting_ = false;
    }
    changed_.notify_all();
}

void PhysicsThread::publish(const PaceFigures &pace)
{
    auto state = std::make_shared<SuiteState>(session_->state());
    state->pace = pace;
    state_.put(std::move(state));
}

// Carries out the actions that the GUI window has requested. Returns false if the thread must end.
bool PhysicsThread::take_actions()
{
    std::vector<Action> actions;
    {
        const Lock lock(mutex_);
        actions.swap(actions_);
        if (must_end_ && actions.empty()) return false;
    }
    for (const Action &action : actions) action(*session_);
    return true;
}

bool PhysicsThread::wait_until(SuiteClock::time_point when)
{
    Lock lock(mutex_);
    return changed_.wait_until(lock, when, [this] { return must_end_ || !actions_.empty(); });
}

void PhysicsThread::run_in_real_time()
{
    Pace pace;
    SuiteClock::time_point published{};
    while (take_actions()) {
        if (SuiteClock::now() - published >= publish_every) {
            published = SuiteClock::now();
            pace.choose_urgency();
            publish(pace.figures());
        }
        const std::int64_t due = session_->has_own_clock() ? 1 : pace.ticks_due();
        if (due == 0 || !session_->fault().empty()) {
            const auto next =
                session_->fault().empty() ? pace.time_of(pace.next()) : SuiteClock::now() + publish_every;
            wait_until(next);
            continue;
        }
        const std::uint32_t before = session_->tick();
        session_->advance(static_cast<std::uint32_t>(due));
        pace.done(session_->has_own_clock() ? session_->tick() - before : due);
    }
    publish(pace.figures());
}

void PhysicsThread::run_counted()
{
    for (;;) {
        std::uint32_t ticks = 0;
        {
            Lock lock(mutex_);
            changed_.wait(lock, [this] { return is_counting_ || must_end_; });
            if (!is_counting_) break;
            ticks = ticks_asked_;
        }
        take_actions();
        if (session_->fault().empty()) session_->advance(ticks);
        publish({});
        {
            const Lock lock(mutex_);
            is_counting_ = false;
        }
        changed_.notify_all();
    }
    take_actions();
}

void PhysicsThread::run_ticks(std::uint32_t ticks)
{
    Lock lock(mutex_);
    ticks_asked_ = ticks;
    is_counting_ = failure_ == nullptr;
    changed_.notify_all();
    changed_.wait(lock, [this] { return !is_counting_; });
    if (failure_) std::rethrow_exception(failure_);
    lock.unlock();
    pictures_.wait_until_idle();
}

void PhysicsThread::check()
{
    const Lock lock(mutex_);
    if (failure_) std::rethrow_exception(failure_);
}

void PhysicsThread::ask(Action action)
{
    {
        const Lock lock(mutex_);
        actions_.push_back(std::move(action));
    }
    changed_.notify_all();
}

std::unique_ptr<LiveSession> PhysicsThread::stop()
{
    {
        const Lock lock(mutex_);
        must_end_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
    if (failure_) std::rethrow_exception(failure_);
    return std::move(session_);
}

} // namespace crn
