#include "host/live/thread_priority.hpp"
#include <charconv>
#include <filesystem>
#include <string>

namespace crn
{

std::set<int> threads_of_process()
{
    std::set<int> threads;
    std::error_code ignored;
    for (const auto &entry : std::filesystem::directory_iterator("/proc/self/task", ignored)) {
        const std::string name = entry.path().filename().string();
        int thread = 0;
        std::from_chars(name.data(), name.data() + name.size(), thread);
        if (thread > 0) threads.insert(thread);
    }
    return threads;
}

void make_other_threads_yield(const std::set<int> &own)
{
    for (int thread : threads_of_process())
        if (!own.contains(thread)) setpriority(PRIO_PROCESS, static_cast<id_t>(thread), renderer_nice);
}

} // namespace crn
