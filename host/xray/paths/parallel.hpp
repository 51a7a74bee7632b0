// Runs the same work on several threads and waits until all threads have finished. Results never depend on
// the number of threads.
#pragma once
#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace crn
{

// Runs work(index) for index 0 .. count-1, each in its own thread; the calling thread runs index 0.
template <class Work> void run_on_threads(int count, const Work &work)
{
    std::vector<std::thread> others;
    for (int index = 1; index < count; ++index) others.emplace_back([&work, index] { work(index); });
    work(0);
    for (std::thread &other : others) other.join();
}

// Returns the rows of a picture that one thread processes when `count` threads divide `rows` rows among
// themselves.
struct RowRange {
    int begin, end;
};
inline RowRange rows_of_thread(int index, int count, int rows)
{
    return {rows * index / count, rows * (index + 1) / count};
}

// Runs work(range) over all rows of a picture, `step` rows at a time; each range of rows goes to the next
// thread that is free.
template <class Work> void run_on_rows(int threads, int rows, int step, const Work &work)
{
    std::atomic<int> next = 0;
    run_on_threads(threads, [&](int) {
        for (int begin = next.fetch_add(step); begin < rows; begin = next.fetch_add(step))
            work(RowRange{begin, std::min(begin + step, rows)});
    });
}

} // namespace crn
