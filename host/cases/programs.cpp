#include "host/cases/programs.hpp"
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <poll.h>
#include <stdexcept>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace crn
{

namespace
{

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int poll_ms = 100;
constexpr double patience_s = 2.0; // between SIGTERM and SIGKILL
constexpr std::size_t said_bytes_max = std::size_t{1} << 20;

// Holds a pipe and closes its two ends when the object is destroyed.
struct Pipe {
    int ends[2] = {-1, -1};
    Pipe()
    {
        if (::pipe2(ends, O_CLOEXEC) != 0)
            throw std::runtime_error(std::string("no pipe can be made: ") + std::strerror(errno));
    }
    ~Pipe()
    {
        close_end(0);
        close_end(1);
    }
    Pipe(const Pipe &) = delete;
    Pipe &operator=(const Pipe &) = delete;
    void close_end(int end)
    {
        if (ends[end] >= 0) ::close(ends[end]);
        ends[end] = -1;
    }
};

std::vector<char *> arguments_of(const std::vector<std::string> &words)
{
    std::vector<char *> arguments;
    for (const std::string &word : words) arguments.push_back(const_cast<char *>(word.c_str()));
    arguments.push_back(nullptr);
    return arguments;
}

[[noreturn]] void become(const std::vector<std::string> &words, const Pipe &said, const Pipe &refused)
{
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    for (int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) std::signal(number, SIG_DFL);
    ::dup2(said.ends[1], STDOUT_FILENO);
    ::dup2(refused.ends[1], STDERR_FILENO);
    std::vector<char *> arguments = arguments_of(words);
    ::execvp(arguments[0], arguments.data());
    ::_exit(127);
}

// Reads the bytes that are available; returns false at the end of the pipe.
bool read_some(Pipe &pipe, std::string &text)
{
    char bytes[4096];
    const ssize_t count = ::read(pipe.ends[0], bytes, sizeof bytes);
    if (count < 0) return errno == EINTR || errno == EAGAIN;
    if (count == 0) return false;
    if (text.size() < said_bytes_max) text.append(bytes, static_cast<std::size_t>(count));
    return true;
}

// Reads both pipes until they end, and ends the process if `goes_on` returns false.
void hear(pid_t process, Pipe &said, Pipe &refused, ProgramResult &result,
          const std::function<bool()> &goes_on)
{
    Clock::time_point stopped_at;
    while (said.ends[0] >= 0 || refused.ends[0] >= 0) {
        pollfd files[2] = {{said.ends[0], POLLIN, 0}, {refused.ends[0], POLLIN, 0}};
        ::poll(files, 2, poll_ms);
        if (files[0].revents && !read_some(said, result.said)) said.close_end(0);
        if (files[1].revents && !read_some(refused, result.refused)) refused.close_end(0);
        if (!result.was_stopped && !goes_on()) {
            result.was_stopped = true;
            stopped_at = Clock::now();
            ::kill(process, SIGTERM);
        }
        if (result.was_stopped &&
            std::chrono::duration<double>(Clock::now() - stopped_at).count() > patience_s)
            ::kill(process, SIGKILL);
    }
}

} // namespace

std::string sibling_program(const std::string &name, const std::string &remedy)
{
    std::error_code failure;
    const fs::path folder = fs::read_symlink("/proc/self/exe", failure).parent_path();
    // Test programs are in other folders of the build tree, and find bin/ in a folder above their own.
    for (fs::path above = folder; above.has_relative_path(); above = above.parent_path())
        for (const fs::path &path : {above / name, above / "bin" / name})
            if (fs::is_regular_file(path, failure) && ::access(path.c_str(), X_OK) == 0) return path.string();
    throw std::runtime_error("the program '" + name + "' is not beside this one, in " + folder.string() +
                             ": " + remedy);
}

void become_program(const std::vector<std::string> &words)
{
    std::vector<char *> arguments = arguments_of(words);
    ::execv(arguments[0], arguments.data());
    throw std::runtime_error(words.at(0) + ": cannot be started: " + std::strerror(errno));
}

ProgramResult run_program(const std::vector<std::string> &words, const std::function<bool()> &goes_on)
{
    Pipe said, refused;
    ProgramResult result;
    const pid_t process = ::fork();
    if (process < 0) throw std::runtime_error(words.at(0) + ": cannot be started: " + std::strerror(errno));
    if (process == 0) become(words, said, refused);
    said.close_end(1);
    refused.close_end(1);
    hear(process, said, refused, result, goes_on);
    int status = 0;
    while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
    }
    result.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    if (result.code == 127 && result.refused.empty())
        throw std::runtime_error(words.at(0) + ": cannot be started: it is no program of this machine");
    return result;
}

} // namespace crn
