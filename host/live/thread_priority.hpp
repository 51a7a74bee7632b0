// Lets the physics run before the pictures and the drawing of the window when they want the same processor.
// On Linux every thread has a nice value of its own, and any program may raise it.
#pragma once
#include <set>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace crn
{

// Nice values: the physics keeps 0. A picture is needed before the screen that shows it.
inline constexpr int picture_nice = 5, renderer_nice = 10, replay_nice = 10;

inline void yield_to_physics(int nice = picture_nice)
{
    // A failure costs only punctuality, and the window shows the real-time factor anyway.
    setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), nice);
}

// Returns the threads of this process, as the kernel numbers them; none where there is no /proc.
std::set<int> threads_of_process();

// Raises the nice value of every thread that is not in `own`. Without a graphics card, OpenGL draws by
// threads that it starts itself, and these threads want every processor.
void make_other_threads_yield(const std::set<int> &own);

} // namespace crn
