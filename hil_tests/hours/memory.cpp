#include "hil_tests/hours/memory.hpp"
#include <filesystem>
#include <fstream>
#include <malloc.h>
#include <unistd.h>

namespace hours
{

Memory memory_now()
{
    Memory memory;
    const struct mallinfo2 heap = mallinfo2();
    memory.heap_bytes = static_cast<std::int64_t>(heap.uordblks + heap.hblkhd);
    std::int64_t pages = 0, resident = 0;
    std::ifstream("/proc/self/statm") >> pages >> resident;
    memory.resident_bytes = resident * sysconf(_SC_PAGESIZE);
    for ([[maybe_unused]] const auto &file : std::filesystem::directory_iterator("/proc/self/fd"))
        memory.files++;
    return memory;
}

} // namespace hours
