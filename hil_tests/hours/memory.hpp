// What this process holds: the bytes of its heap in use, the pages in memory, and the open files.
#pragma once
#include <cstdint>

namespace hours
{

struct Memory {
    std::int64_t heap_bytes = 0, resident_bytes = 0, files = 0;
};
Memory memory_now();

} // namespace hours
