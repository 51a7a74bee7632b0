#include "host/app/interrupt.hpp"
#include "host/model/pending_file.hpp"
#include <csignal>

namespace seld
{

namespace
{

volatile std::sig_atomic_t interrupted = 0;

void on_signal(int number)
{
    if (interrupted == 0) {
        interrupted = 1;
        return;
    }
    remove_pending();
    std::signal(number, SIG_DFL);
    std::raise(number);
}

} // namespace

void watch_for_interrupt()
{
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
}

bool is_interrupted()
{
    return interrupted != 0;
}

} // namespace seld
