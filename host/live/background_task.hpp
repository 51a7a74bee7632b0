// Runs a long piece of work in a separate thread, so that the GUI window never waits for it.
//
//   BackgroundTask<Scene> task([](TaskProgress &progress) { return make_scene(progress); });
//   if (const Scene *made = task.result()) ...      in every frame of the window
//
// The destructor asks the work to end, and waits until it has ended.
#pragma once
#include <atomic>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace crn
{

// Passes the progress of the work to the GUI window, and tells the work whether it may continue.
class TaskProgress
{
  public:
    // `share` is the completed share of the work, 0 to 1, or a negative number if it is not known. Returns
    // false if the work must end.
    bool tell(const std::string &stage, double share)
    {
        const std::lock_guard lock(mutex_);
        stage_ = stage;
        share_ = share;
        return !is_cancelled_;
    }
    std::string stage() const
    {
        const std::lock_guard lock(mutex_);
        return stage_;
    }
    double share() const { return share_; }
    bool goes_on() const { return !is_cancelled_; }
    void cancel() { is_cancelled_ = true; }

  private:
    mutable std::mutex mutex_;
    std::string stage_;
    std::atomic<double> share_ = -1.0;
    std::atomic<bool> is_cancelled_ = false;
};

template <class Result> class BackgroundTask
{
  public:
    using Work = std::function<Result(TaskProgress &)>;

    explicit BackgroundTask(Work work) : work_(std::move(work)), thread_([this] { run(); }) {}
    ~BackgroundTask()
    {
        progress_.cancel();
        thread_.join();
    }
    BackgroundTask(const BackgroundTask &) = delete;
    BackgroundTask &operator=(const BackgroundTask &) = delete;

    bool is_done() const { return is_done_; }
    // Returns the result, or null if the work has not ended yet or has failed.
    const Result *result() const { return is_done_ && result_ ? &*result_ : nullptr; }
    // Moves the result out of the task; the caller may call this only after result() was not null.
    Result take() { return std::move(*result_); }
    // Returns the reason why there is no result; the text is empty until the work has ended.
    std::string trouble() const { return is_done_ ? trouble_ : std::string(); }
    const TaskProgress &progress() const { return progress_; }
    void cancel() { progress_.cancel(); }

  private:
    void run()
    {
        try {
            result_.emplace(work_(progress_));
        } catch (const std::exception &error) {
            trouble_ = error.what();
        }
        is_done_ = true;
    }

    Work work_;
    TaskProgress progress_;
    std::optional<Result> result_;
    std::string trouble_;
    std::atomic<bool> is_done_ = false;
    std::thread thread_; // the last member, because it uses the others
};

} // namespace crn
