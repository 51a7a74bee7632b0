// Advances a live session in a separate thread, 1000 ticks per second. The GUI window requests actions, which
// this thread carries out before its next tick, and takes copies of the state from a mailbox.
//
//   PhysicsThread physics(std::move(session), PhysicsPace::real_time);
//   physics.ask([](LiveSession &live) { live.command({RoomAction::halt, {}}); });
//   std::shared_ptr<const SuiteState> state = physics.state();
//   std::unique_ptr<LiveSession> session = physics.stop();
#pragma once
#include "host/live/live_session.hpp"
#include "host/live/mailbox.hpp"
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace crn
{

// In the pace `counted`, time advances only through run_ticks(), so that a test does not depend on the clock.
enum class PhysicsPace { real_time, counted };

class PhysicsThread
{
  public:
    using Action = std::function<void(LiveSession &)>;

    PhysicsThread(std::unique_ptr<LiveSession> session, PhysicsPace pace);
    ~PhysicsThread();
    PhysicsThread(const PhysicsThread &) = delete;
    PhysicsThread &operator=(const PhysicsThread &) = delete;

    void ask(Action action);
    std::shared_ptr<const SuiteState> state() const { return state_.latest(); }
    std::shared_ptr<const MonitorPicture> live() const { return pictures_.live(); }
    std::shared_ptr<const MonitorPicture> reference() const { return pictures_.reference(); }
    void show_reference(const ReferenceChoice &choice) { pictures_.show_reference(choice); }
    void on_picture(std::function<void()> told) { pictures_.on_picture(std::move(told)); }
    // Throws what the thread has thrown, for example because the recording's disk is full.
    void check();
    // In the pace `counted`, the function carries out the requested actions and then this number of ticks,
    // and waits for the pictures of these ticks. Throws what the session throws.
    void run_ticks(std::uint32_t ticks);
    // Ends the thread and returns the session. Throws the exception with which the session has failed.
    std::unique_ptr<LiveSession> stop();

  private:
    using Lock = std::unique_lock<std::mutex>;
    void run();
    void run_counted();
    void run_in_real_time();
    void publish(const PaceFigures &pace);
    bool take_actions();
    bool wait_until(SuiteClock::time_point when);

    std::unique_ptr<LiveSession> session_;
    PictureThread &pictures_;
    const PhysicsPace pace_;
    Mailbox<SuiteState> state_;

    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<Action> actions_;
    std::uint32_t ticks_asked_ = 0;
    bool is_counting_ = false, must_end_ = false;
    std::exception_ptr failure_;
    std::thread thread_; // the last member, because it uses the others
};

} // namespace crn
