// Runs a ReplayRoom in two threads: one prepares the track (the states over the session), and the other
// computes the picture that the GUI window requested last.
#pragma once
#include "host/live/mailbox.hpp"
#include "host/live/replay_room.hpp"
#include <condition_variable>
#include <optional>
#include <thread>

namespace crn
{

struct ReplayShown {
    ReplayPicture picture;
    std::uint64_t number = 0;
    double took_ms = 0.0;
    std::string trouble; // why there is no picture; empty: there is one
};

class ReplayThread
{
  public:
    explicit ReplayThread(std::unique_ptr<ReplayRoom> room);
    ~ReplayThread();
    ReplayThread(const ReplayThread &) = delete;
    ReplayThread &operator=(const ReplayThread &) = delete;

    void ask(const ReplayAsk &ask);
    std::shared_ptr<const ReplayShown> latest() const { return shown_.latest(); }
    const ReplayRoom &room() const { return *room_; } // its constants, and prepared()

  private:
    void prepare();
    void draw();

    std::unique_ptr<ReplayRoom> room_;
    Mailbox<ReplayShown> shown_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::optional<ReplayAsk> asked_;
    bool must_end_ = false;
    std::thread track_, pictures_;
};

} // namespace crn
