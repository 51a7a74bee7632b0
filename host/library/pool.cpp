#include "host/library/pool.hpp"
#include <system_error>
#include <unistd.h>

namespace crn::library
{

Pool::Pool(std::uint32_t threads) : owner_(getpid())
{
    try {
        for (std::uint32_t i = 1; i < threads; i++)
            shared_->threads.emplace_back([&shared = *shared_] { serve(shared); });
    } catch (const std::system_error &error) {
        close();
        throw Refused(COURNAND_NO_MEMORY, std::string("the system starts no more threads: ") + error.what());
    }
}

// A child process of fork() has a copy of the parent's memory, but none of the parent's threads. The child
// process cannot wait for the parent's threads, so the copy of their data stays allocated until the child
// ends.
Pool::~Pool()
{
    if (getpid() == owner_)
        close();
    else
        static_cast<void>(shared_.release());
}

void Pool::close()
{
    {
        const std::lock_guard lock(shared_->mutex);
        shared_->is_closing = true;
    }
    shared_->begins.notify_all();
    for (std::thread &thread : shared_->threads) thread.join();
    shared_->threads.clear();
}

void Pool::take_part(Shared &shared, std::size_t count, const std::function<void(std::size_t)> &work)
{
    for (std::size_t i = shared.next.fetch_add(1); i < count; i = shared.next.fetch_add(1)) work(i);
}

void Pool::serve(Shared &shared)
{
    std::uint64_t seen = 0;
    for (std::unique_lock lock(shared.mutex);;) {
        shared.begins.wait(lock, [&] { return shared.is_closing || shared.round != seen; });
        if (shared.is_closing) return;
        seen = shared.round;
        const std::size_t count = shared.count;
        const std::function<void(std::size_t)> &work = *shared.work;
        lock.unlock();
        take_part(shared, count, work);
        lock.lock();
        if (--shared.working == 0) shared.ends.notify_one();
    }
}

void Pool::run(std::size_t count, const std::function<void(std::size_t)> &work)
{
    if (getpid() != owner_)
        throw Refused(COURNAND_BAD_STATE,
                      "the pool belongs to the parent of this process: make another pool here");
    {
        const std::lock_guard lock(shared_->mutex);
        shared_->work = &work;
        shared_->count = count;
        shared_->working = shared_->threads.size();
        shared_->next = 0;
        shared_->round++;
    }
    shared_->begins.notify_all();
    take_part(*shared_, count, work);
    std::unique_lock lock(shared_->mutex);
    shared_->ends.wait(lock, [&] { return shared_->working == 0; });
}

} // namespace crn::library
