// Lets the physics run before the pictures if both need the same processor. On Linux every thread has its own
// nice value, and any program may raise it.
#pragma once
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace crn
{

inline void yield_to_physics(int nice = 5)
{
    // If the call fails, the physics is only less punctual, and the GUI window shows the real-time factor
    // anyway.
    setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), nice);
}

} // namespace crn
