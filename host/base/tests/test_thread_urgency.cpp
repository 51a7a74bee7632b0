// The kernel schedules an urgent thread before threads that compute, as far as the user's rights permit this.
// Threads and processes that an urgent thread starts have ordinary scheduling.
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "host/base/thread_urgency.hpp"

extern "C" {
#include <cmocka.h>
}

namespace
{

using crn::ThreadUrgency;

int own_policy()
{
    return sched_getscheduler(0) & ~SCHED_RESET_ON_FORK;
}

// Runs `check` in a process of a user without rights, and returns its exit code.
int without_rights(int (*check)())
{
    const pid_t pid = fork();
    if (pid == 0) {
        const rlimit none{0, 0};
        setrlimit(RLIMIT_RTPRIO, &none);
        if (geteuid() == 0 && syscall(SYS_setresuid, 65534, 65534, 65534) != 0) _exit(100);
        _exit(check());
    }
    int status = 0;
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

void the_answer_is_what_the_kernel_granted(void **)
{
    std::thread([] {
        const ThreadUrgency granted = crn::make_thread_urgent();
        const bool is_real_time = granted == ThreadUrgency::real_time;
        assert_int_equal(own_policy(), is_real_time ? SCHED_RR : SCHED_OTHER);
    }).join();
}

void a_user_without_rights_gets_no_real_time(void **)
{
    assert_int_equal(without_rights([] {
                         if (crn::make_thread_urgent() == ThreadUrgency::real_time) return 1;
                         return own_policy() == SCHED_OTHER ? 0 : 2;
                     }),
                     0);
}

void an_urgent_thread_starts_ordinary_threads(void **)
{
    std::thread([] {
        crn::make_thread_urgent();
        int policy = -1;
        std::thread([&] { policy = own_policy(); }).join();
        assert_int_equal(policy, SCHED_OTHER);
    }).join();
}

void a_thread_becomes_ordinary_again(void **)
{
    std::thread([] {
        crn::make_thread_urgent();
        crn::make_thread_ordinary();
        assert_int_equal(own_policy(), SCHED_OTHER);
    }).join();
}

void the_nice_value_stays(void **)
{
    assert_int_equal(without_rights([] {
                         setpriority(PRIO_PROCESS, 0, 7);
                         crn::make_thread_urgent();
                         crn::make_thread_ordinary();
                         return getpriority(PRIO_PROCESS, 0);
                     }),
                     7);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(the_answer_is_what_the_kernel_granted),
        cmocka_unit_test(a_user_without_rights_gets_no_real_time),
        cmocka_unit_test(an_urgent_thread_starts_ordinary_threads),
        cmocka_unit_test(a_thread_becomes_ordinary_again),
        cmocka_unit_test(the_nice_value_stays),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
