#include "hil_tests/soak/process.hpp"
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace soak
{

namespace
{

[[noreturn]] void be_process(int pipe, const std::function<std::optional<std::string>()> &work)
{
    prctl(PR_SET_PDEATHSIG, SIGKILL); // no process is left behind
    const std::optional<std::string> text = work();
    if (!text) _exit(1);
    for (std::size_t done = 0; done < text->size();) {
        const ssize_t count = write(pipe, text->data() + done, text->size() - done);
        if (count <= 0) _exit(1);
        done += static_cast<std::size_t>(count);
    }
    _exit(0);
}

} // namespace

Process start_process(const std::function<std::optional<std::string>()> &work)
{
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error(std::string("no pipe: ") + std::strerror(errno));
    std::fflush(nullptr);
    const pid_t who = fork();
    if (who < 0) throw std::runtime_error(std::string("no process: ") + std::strerror(errno));
    if (who == 0) {
        close(ends[0]);
        be_process(ends[1], work);
    }
    close(ends[1]);
    return {who, ends[0]};
}

int status_of_end(pid_t who)
{
    int status = 0;
    while (waitpid(who, &status, 0) < 0 && errno == EINTR) {
    }
    return status;
}

} // namespace soak
