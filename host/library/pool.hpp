// Provides threads that work on many worlds (simulated sessions) at the same time. The results do not depend
// on the number of threads, because one thread computes each world.
#pragma once
#include "host/library/handles.hpp"
#include <condition_variable>
#include <functional>
#include <mutex>
#include <sys/types.h>
#include <thread>
#include <vector>

namespace crn::library
{

class Pool
{
  public:
    explicit Pool(std::uint32_t threads); // with the calling thread
    ~Pool();
    Pool(const Pool &) = delete;
    Pool &operator=(const Pool &) = delete;

    // Calls work(i) once for each i below `count`; `work` must not throw. Throws Refused in a child process
    // of fork(), which does not have the threads.
    void run(std::size_t count, const std::function<void(std::size_t)> &work);

    OneAtATime door;

  private:
    // What the threads share.
    struct Shared {
        std::mutex mutex;
        std::condition_variable begins, ends;
        std::uint64_t round = 0; // counts the calls of run()
        bool is_closing = false;
        const std::function<void(std::size_t)> *work = nullptr;
        std::size_t count = 0, working = 0; // threads that have not finished this round
        std::atomic<std::size_t> next = 0;
        std::vector<std::thread> threads;
    };
    static void serve(Shared &shared);
    static void take_part(Shared &shared, std::size_t count, const std::function<void(std::size_t)> &work);
    void close();

    const pid_t owner_;
    std::unique_ptr<Shared> shared_ = std::make_unique<Shared>();
};

template <> struct HandleOf<cournand_pool> {
    using Object = Pool;
    static constexpr HandleKind kind = HandleKind::pool;
    static constexpr char name[] = "pool";
};

} // namespace crn::library
