#include "tools/lab/calibrate/thread_pool.hpp"
#include <chrono>
#include <utility>

namespace crn::calibrate
{

ThreadPool::ThreadPool(unsigned threads, Evaluate evaluate) : evaluate_(std::move(evaluate))
{
    for (unsigned i = 0; i < std::max(1u, threads); i++) threads_.emplace_back([this] { work(); });
}

ThreadPool::~ThreadPool()
{
    {
        const std::lock_guard lock(mutex_);
        is_over_ = true;
    }
    wanted_.notify_all();
    for (std::thread &thread : threads_) thread.join();
}

void ThreadPool::give(std::size_t index, std::vector<double> values)
{
    {
        const std::lock_guard lock(mutex_);
        waiting_.emplace_back(index, std::move(values));
    }
    wanted_.notify_one();
}

std::vector<ThreadPool::Done> ThreadPool::take(int wait_ms)
{
    std::unique_lock lock(mutex_);
    finished_.wait_for(lock, std::chrono::milliseconds(wait_ms), [this] { return !done_.empty(); });
    return std::exchange(done_, {});
}

void ThreadPool::clear()
{
    const std::lock_guard lock(mutex_);
    waiting_.clear();
}

void ThreadPool::work()
{
    std::unique_lock lock(mutex_);
    for (;;) {
        wanted_.wait(lock, [this] { return is_over_ || !waiting_.empty(); });
        if (is_over_) return;
        auto [index, values] = std::move(waiting_.front());
        waiting_.pop_front();
        lock.unlock();
        Done done{index, {}, nullptr};
        try {
            done.verdict = evaluate_(values);
        } catch (...) {
            done.failure = std::current_exception();
        }
        lock.lock();
        done_.push_back(std::move(done));
        finished_.notify_one();
    }
}

namespace
{

constexpr int look_ms = 100; // interval between two checks for a stop request

class ThreadWorkers final : public Workers
{
  public:
    ThreadWorkers(unsigned threads, Evaluate evaluate, Stop stop, Progress progress)
        : pool_(threads, std::move(evaluate)), stop_(std::move(stop)), progress_(std::move(progress))
    {
    }

    std::vector<Verdict> evaluate(const std::vector<std::vector<double>> &trials) override
    {
        std::vector<Verdict> verdicts(trials.size());
        for (std::size_t i = 0; i < trials.size(); i++) pool_.give(i, trials[i]);
        for (std::size_t count = 0; count < trials.size();) {
            for (ThreadPool::Done &done : pool_.take(look_ms)) {
                if (done.failure) {
                    pool_.clear();
                    std::rethrow_exception(done.failure);
                }
                verdicts[done.index] = done.verdict;
                count++;
            }
            if (stop_ && stop_()) {
                pool_.clear();
                throw Interrupted();
            }
            if (progress_) progress_(count);
        }
        return verdicts;
    }

    std::string description() const override
    {
        return std::to_string(pool_.size()) + (pool_.size() == 1 ? " thread" : " threads");
    }

  private:
    ThreadPool pool_;
    Stop stop_;
    Progress progress_;
};

} // namespace

std::unique_ptr<Workers> thread_workers(unsigned threads, Evaluate evaluate, Stop stop, Progress progress)
{
    return std::make_unique<ThreadWorkers>(threads, std::move(evaluate), std::move(stop),
                                           std::move(progress));
}

} // namespace crn::calibrate
