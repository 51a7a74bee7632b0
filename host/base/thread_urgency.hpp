// Controls how the kernel schedules the calling thread among other threads. A thread that must act every
// millisecond cannot wait until a computing thread has used up its time slice of 3 to 4 ms.
//
//   make_thread_urgent();      at the begin of the thread
//   make_thread_ordinary();    when it computes without a pause, so that it does not lock out others
#pragma once

namespace crn
{

enum class ThreadUrgency {
    real_time,    // runs before all ordinary threads (POSIX SCHED_RR)
    short_slices, // ordinary priority in short shares of time (Linux 6.12 and later)
    ordinary
};

// Requests the scheduling with the shortest delays that this user may have, and returns what the kernel
// granted. The real-time class needs the limit RLIMIT_RTPRIO of at least 1 (`ulimit -r`). Threads that this
// thread starts later have ordinary scheduling.
ThreadUrgency make_thread_urgent();
void make_thread_ordinary();

// Returns "real time", "short slices" or "ordinary".
const char *text_of(ThreadUrgency urgency);

} // namespace crn
