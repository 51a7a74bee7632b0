// Lets the physics run before the pictures when both want the same processor. On Linux every thread has a
// nice value of its own, and any program may raise it.
#pragma once
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace crn
{

inline void yield_to_physics(int nice = 5)
{
    // A failure costs only punctuality, and the window shows the real-time factor anyway.
    setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), nice);
}

} // namespace crn
