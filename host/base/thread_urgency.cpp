#include "host/base/thread_urgency.hpp"
#include <cstdint>
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace crn
{
namespace
{

constexpr int real_time_priority = 1; // the lowest of the class: above ordinary threads, below all drivers
constexpr std::uint64_t slice_ns = 100'000;

// Describes the argument of the system call sched_setattr (man page sched_setattr(2)), which glibc 2.36 does
// not declare.
struct SchedulingRequest {
    std::uint32_t size = sizeof(SchedulingRequest);
    std::uint32_t policy = SCHED_OTHER;
    std::uint64_t flags = 0;
    std::int32_t nice = 0;
    std::uint32_t priority = 0;
    std::uint64_t runtime_ns = 0; // for SCHED_OTHER: the length of a share of time, 0: the kernel's own
    std::uint64_t deadline_ns = 0, period_ns = 0;
};

constexpr std::uint64_t flag_reset_on_fork = 1; // threads that this thread starts are ordinary

// Requests ordinary scheduling with time slices of the given length; 0 means the kernel's default length. The
// nice value stays.
bool request_shares_of(std::uint64_t slice)
{
    SchedulingRequest wanted;
    wanted.flags = flag_reset_on_fork;
    wanted.nice = getpriority(PRIO_PROCESS, 0);
    wanted.runtime_ns = slice;
    return syscall(SYS_sched_setattr, 0, &wanted, 0U) == 0;
}

// Returns the length of this thread's time slice, or 0 if the kernel does not support such lengths.
std::uint64_t granted_slice_ns()
{
    SchedulingRequest granted;
    if (syscall(SYS_sched_getattr, 0, &granted, sizeof granted, 0U) != 0) return 0;
    return granted.runtime_ns;
}

} // namespace

ThreadUrgency make_thread_urgent()
{
    const sched_param priority{.sched_priority = real_time_priority};
    if (pthread_setschedparam(pthread_self(), SCHED_RR | SCHED_RESET_ON_FORK, &priority) == 0)
        return ThreadUrgency::real_time;
    if (request_shares_of(slice_ns) && granted_slice_ns() == slice_ns) return ThreadUrgency::short_slices;
    return ThreadUrgency::ordinary;
}

void make_thread_ordinary()
{
    request_shares_of(0);
}

const char *text_of(ThreadUrgency urgency)
{
    switch (urgency) {
    case ThreadUrgency::real_time:
        return "real time";
    case ThreadUrgency::short_slices:
        return "short slices";
    default:
        return "ordinary";
    }
}

} // namespace crn
