#include "host/base/interrupt.hpp"
#include "host/base/pending_file.hpp"
#include <csignal>

namespace crn
{

namespace
{

volatile std::sig_atomic_t interrupted = 0;

void on_interrupt(int number)
{
    if (interrupted == 0) {
        interrupted = 1;
        return;
    }
    remove_pending();
    std::signal(number, SIG_DFL);
    // While a handler of a signal runs, that signal is blocked, and the parent process may have blocked it
    // too. The call of pthread_sigmask below unblocks the signal, so that the signal ends the program here.
    sigset_t both;
    ::sigemptyset(&both);
    ::sigaddset(&both, number);
    std::raise(number);
    ::pthread_sigmask(SIG_UNBLOCK, &both, nullptr);
}

} // namespace

void watch_for_interrupt()
{
    sigset_t both;
    ::sigemptyset(&both);
    for (int number : {SIGINT, SIGTERM}) {
        std::signal(number, on_interrupt);
        ::sigaddset(&both, number);
    }
    ::pthread_sigmask(SIG_UNBLOCK, &both, nullptr);
}

bool is_interrupted()
{
    return interrupted != 0;
}

} // namespace crn
