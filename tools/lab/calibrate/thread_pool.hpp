// Runs threads that evaluate the trials of a search as the trials arrive, and that return the results in any
// order.
#pragma once
#include "tools/lab/calibrate/workers.hpp"
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

namespace crn::calibrate
{

class ThreadPool
{
  public:
    struct Done {
        std::size_t index;
        Verdict verdict;
        std::exception_ptr failure;
    };

    ThreadPool(unsigned threads, Evaluate evaluate);
    ~ThreadPool(); // finishes the running trials and discards the others

    unsigned size() const { return static_cast<unsigned>(threads_.size()); }
    void give(std::size_t index, std::vector<double> values);
    // Returns the results that have arrived since the last call; if there are none, waits at most `wait_ms`
    // for the first one.
    std::vector<Done> take(int wait_ms);
    // Discards the trials that no thread has begun to evaluate.
    void clear();

  private:
    void work();

    Evaluate evaluate_;
    std::mutex mutex_;
    std::condition_variable wanted_, finished_;
    std::deque<std::pair<std::size_t, std::vector<double>>> waiting_;
    std::vector<Done> done_;
    bool is_over_ = false;
    std::vector<std::thread> threads_;
};

} // namespace crn::calibrate
