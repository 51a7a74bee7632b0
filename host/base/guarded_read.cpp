// Runs the child process that reads a file, sets its limits, and interprets its exit.
#include "host/base/guarded_read.hpp"
#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <new>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

// Programs with an address sanitizer map terabytes of memory, which exceeds any limit on the address space.
// In sanitized builds the parent process therefore watches the child's memory instead.
#if defined(__SANITIZE_ADDRESS__)
#define CRN_WATCHES_MEMORY 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define CRN_WATCHES_MEMORY 1
#endif
#endif
#ifndef CRN_WATCHES_MEMORY
#define CRN_WATCHES_MEMORY 0
#endif

namespace crn
{

namespace
{

constexpr char has_data = 'D', has_refusal = 'F';
constexpr std::size_t heard_bytes_max = 2048;
constexpr char interrupted_text[] = "interrupted while it was read";
constexpr int look_ms = 20; // how often memory and time are checked

bool (*is_stop_wanted)() = nullptr;

void send(int pipe, const void *bytes, std::size_t count)
{
    const char *at = static_cast<const char *>(bytes);
    while (count > 0) {
        const ssize_t sent = ::write(pipe, at, count);
        if (sent < 0 && errno == EINTR) continue;
        if (sent <= 0) ::_exit(3); // the parent has ended
        at += sent;
        count -= static_cast<std::size_t>(sent);
    }
}

// Returns how many bytes of memory a process has, either in its address space or resident in memory.
std::uint64_t process_bytes(const char *path, bool is_resident)
{
    unsigned long long pages = 0, resident = 0;
    if (std::FILE *file = std::fopen(path, "r")) {
        if (std::fscanf(file, "%llu %llu", &pages, &resident) != 2) pages = resident = 0;
        std::fclose(file);
    }
    return (is_resident ? resident : pages) * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

void limit(int what, std::uint64_t soft, std::uint64_t hard)
{
    struct rlimit now {
    };
    ::getrlimit(static_cast<__rlimit_resource_t>(what), &now);
    now.rlim_cur = std::min<rlim_t>(now.rlim_max, soft);
    now.rlim_max = std::min<rlim_t>(now.rlim_max, hard);
    ::setrlimit(static_cast<__rlimit_resource_t>(what), &now);
}

void set_limits(const ReadLimits &limits, std::uint64_t space_before)
{
    const auto cpu_s = static_cast<std::uint64_t>(std::ceil(limits.cpu_s));
    limit(RLIMIT_CPU, cpu_s, cpu_s + 1);
    limit(RLIMIT_STACK, limits.stack_bytes, limits.stack_bytes);
    limit(RLIMIT_CORE, 0, 0);
    if (CRN_WATCHES_MEMORY) return;
    const std::uint64_t space = space_before + limits.memory_bytes;
    limit(RLIMIT_AS, space, space);
    limit(RLIMIT_FSIZE, 0, 0); // it must not leave any file behind (such as a sanitizer's report)
}

// The signal handlers of the parent process would remove the parent's files, so the child process resets
// these signals to their default actions.
void reset_signals()
{
    for (int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGALRM}) std::signal(number, SIG_DFL);
    // The program's fault handler might jump back into the program, which would then continue in the child.
    // So the child resets it. Under a sanitizer the fault handler only prints a report, so the child keeps
    // this handler.
    if (!CRN_WATCHES_MEMORY)
        for (int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGSYS}) std::signal(number, SIG_DFL);
    sigset_t none;
    sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
}

[[noreturn]] void be_child(const std::string &file, const ReadLimits &limits, std::uint64_t space_before,
                           const std::function<void(Outbox &)> &parse, int pipe)
{
    set_limits(limits, space_before);
    Outbox out(pipe);
    std::string refusal;
    try {
        parse(out);
        if (!out.is_begun()) out.bytes(nullptr, 0);
        ::_exit(0);
    } catch (const std::bad_alloc &) {
        refusal = file + ": reading it takes over " + std::to_string(limits.memory_bytes >> 20) +
                  " MiB of memory: the file is damaged, or too large; export it again, with fewer details";
    } catch (const std::exception &error) {
        refusal = *error.what() ? error.what() : file + ": cannot be read: export it again";
    } catch (...) {
        refusal = file + ": cannot be read: export it again";
    }
    if (out.is_begun()) ::_exit(4);
    send(pipe, &has_refusal, 1);
    send(pipe, refusal.data(), std::min<std::size_t>(refusal.size(), 1 << 16));
    ::_exit(0);
}

// Takes the first line of the messages that a library printed, and makes printable text of at most 160
// characters from it.
std::string plain_line(const std::string &heard)
{
    std::string line;
    for (const char c : heard) {
        if (c == '\n' && !line.empty()) break;
        if (line.size() == 160) return line + "...";
        line += c >= ' ' && c <= '~' ? c : ' ';
    }
    return line;
}

std::string rounded(double value)
{
    return std::to_string(static_cast<long long>(std::llround(value)));
}

} // namespace

ReadLimits read_limits(std::uint64_t file_bytes, double growth)
{
    constexpr double base_bytes = 384.0 * (1 << 20), small_MiB = 8;
    const double MiB = static_cast<double>(file_bytes) / (1 << 20),
                 beyond_MiB = std::max(0.0, MiB - small_MiB);
    ReadLimits limits;
    const double wanted = base_bytes + growth * static_cast<double>(file_bytes);
    limits.memory_bytes = static_cast<std::uint64_t>(std::min(wanted, double(read_memory_bytes_max)));
    limits.cpu_s = 10 + 0.5 * beyond_MiB;
    limits.wall_s = 18 + 2.0 * beyond_MiB;
    return limits;
}

void stop_reading_when(bool (*is_wanted)())
{
    is_stop_wanted = is_wanted;
}

std::uint64_t regular_file_bytes(const std::string &file, std::uint64_t most)
{
    struct stat info {
    };
    if (::stat(file.c_str(), &info) != 0)
        throw GuardedReadError(file + ": cannot be read: " + std::strerror(errno));
    if (!S_ISREG(info.st_mode)) throw GuardedReadError(file + ": is no file: give a file");
    const auto bytes = static_cast<std::uint64_t>(info.st_size);
    if (bytes > most)
        throw GuardedReadError(file + ": has " + std::to_string(bytes >> 20) + " MiB, over " +
                               std::to_string(most >> 20) + " MiB: give a smaller file");
    return bytes;
}

// --- the child's side
// ------------------------------------------------------------------------------------------------
void Outbox::bytes(const void *bytes, std::size_t count)
{
    if (!is_begun_) send(pipe_, &has_data, 1);
    is_begun_ = true;
    send(pipe_, bytes, count);
}

void Outbox::text(std::string_view text)
{
    value<std::uint64_t>(text.size());
    bytes(text.data(), text.size());
}

// --- the parent's side
// -----------------------------------------------------------------------------------------------
Inbox::Inbox(const std::string &file, const ReadLimits &limits)
    : file_(file), limits_(limits), began_(std::chrono::steady_clock::now())
{
}

Inbox::~Inbox()
{
    end_child();
    if (pipe_ >= 0) ::close(pipe_);
    if (noise_ >= 0) ::close(noise_);
}

void Inbox::start(const std::function<void(Outbox &)> &parse)
{
    int data[2], noise[2];
    if (::pipe2(data, O_CLOEXEC) != 0) fail(std::string("no pipe for reading it: ") + std::strerror(errno));
    if (::pipe2(noise, O_CLOEXEC) != 0) {
        ::close(data[0]), ::close(data[1]);
        fail(std::string("no pipe for reading it: ") + std::strerror(errno));
    }
    pipe_ = data[0], noise_ = noise[0];
    ::fcntl(noise_, F_SETFL, O_NONBLOCK);
    const std::uint64_t space_before = process_bytes("/proc/self/statm", false);
    // Signals are blocked around fork, because no signal may reach the child process while it still has its
    // parent's handlers.
    sigset_t all, before;
    sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, &before);
    std::fflush(nullptr);
    const pid_t parent = ::getpid();
    child_ = ::fork();
    if (child_ == 0) {
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        if (::getppid() != parent) ::_exit(3);
        reset_signals();
        ::dup2(noise[1], STDOUT_FILENO);
        ::dup2(noise[1], STDERR_FILENO);
        ::close(data[0]);
        be_child(file_, limits_, space_before, parse, data[1]);
    }
    const int reason = errno;
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
    ::close(data[1]), ::close(noise[1]);
    if (child_ < 0) fail(std::string("no process for reading it: ") + std::strerror(reason));
}

void Inbox::hear()
{
    std::array<char, 4096> block;
    for (ssize_t got; (got = ::read(noise_, block.data(), block.size())) > 0;)
        heard_.append(block.data(),
                      std::min<std::size_t>(static_cast<std::size_t>(got),
                                            heard_bytes_max - std::min(heard_bytes_max, heard_.size())));
}

void Inbox::wait()
{
    const std::string child_memory = "/proc/" + std::to_string(child_) + "/statm";
    const std::uint64_t before = CRN_WATCHES_MEMORY ? process_bytes("/proc/self/statm", true) : 0;
    for (;;) {
        struct pollfd ends[2] = {{pipe_, POLLIN, 0}, {noise_, POLLIN, 0}};
        const int ready = ::poll(ends, 2, look_ms);
        if (ready < 0 && errno != EINTR)
            fail(std::string("cannot wait for its reader: ") + std::strerror(errno));
        if (is_stop_wanted && is_stop_wanted()) fail(interrupted_text);
        if (ready > 0 && ends[1].revents != 0) {
            hear();
            if (ends[1].revents & POLLHUP && !(ends[1].revents & POLLIN)) { // closed by a library
                ::close(noise_);
                noise_ = -1;
            }
        }
        if (ready > 0 && ends[0].revents != 0) return;
        const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - began_;
        if (passed.count() > limits_.wall_s)
            fail("its reader was not done after " + rounded(limits_.wall_s) +
                 " s: the file is damaged, or this machine is too slow for it; export it again, with fewer "
                 "details");
        if (CRN_WATCHES_MEMORY && process_bytes(child_memory.c_str(), true) > before + limits_.memory_bytes)
            fail("reading it takes over " + std::to_string(limits_.memory_bytes >> 20) +
                 " MiB of memory: the file is damaged, or too large; export it again, with fewer details");
    }
}

void Inbox::bytes(void *bytes, std::size_t count)
{
    char *at = static_cast<char *>(bytes);
    while (count > 0) {
        wait();
        const ssize_t got = ::read(pipe_, at, count);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) fail_ended();
        at += got;
        count -= static_cast<std::size_t>(got);
    }
}

std::uint64_t Inbox::size(std::uint64_t most)
{
    const auto count = value<std::uint64_t>();
    if (count > most)
        fail("its reader gives " + std::to_string(count) + " values where at most " + std::to_string(most) +
             " are possible: the file is damaged; export it again");
    return count;
}

std::string Inbox::text(std::uint64_t most)
{
    std::string text(size(most), ' ');
    bytes(text.data(), text.size());
    return text;
}

void Inbox::end_child()
{
    if (child_ <= 0) return;
    ::kill(child_, SIGKILL);
    while (::waitpid(child_, &status_, 0) < 0 && errno == EINTR) {
    }
    child_ = -1;
}

void Inbox::fail(const std::string &what)
{
    end_child();
    throw GuardedReadError(file_ + ": " + what);
}

void Inbox::fail_ended()
{
    // The child process has closed its pipe, so it has ended or will end immediately.
    while (child_ > 0 && ::waitpid(child_, &status_, 0) < 0 && errno == EINTR) {
    }
    child_ = -1;
    if (noise_ >= 0) hear();
    const int number = WIFSIGNALED(status_) ? WTERMSIG(status_) : 0;
    if (number == SIGINT || number == SIGTERM || number == SIGHUP) fail(interrupted_text);
    if (number == SIGXCPU)
        fail("its reader was not done after " + rounded(limits_.cpu_s) +
             " s of the processor: the file is damaged, or too large; export it again, with fewer details");
    const std::string said = plain_line(heard_);
    fail(std::string("is damaged in a way that ends its reader (") +
         (number != 0 ? ::strsignal(number) : "it stopped") + (said.empty() ? "" : ": " + said) +
         "): export it again");
}

void Inbox::finish()
{
    char more = 0;
    for (;;) {
        wait();
        const ssize_t got = ::read(pipe_, &more, 1);
        if (got < 0 && errno == EINTR) continue;
        if (got > 0) fail("its reader says more than it announced: the file is damaged; export it again");
        break;
    }
    while (::waitpid(child_, &status_, 0) < 0 && errno == EINTR) {
    }
    child_ = -1;
    if (!WIFEXITED(status_) || WEXITSTATUS(status_) != 0) fail_ended();
}

void read_apart(const std::string &file, const ReadLimits &limits, const std::function<void(Outbox &)> &parse,
                const std::function<void(Inbox &)> &take)
{
    Inbox in(file, limits);
    in.start(parse);
    if (in.value<char>() != has_data) {
        std::string refusal;
        for (char c; in.wait(), ::read(in.pipe_, &c, 1) == 1;) refusal += c;
        in.end_child();
        throw GuardedReadError(refusal);
    }
    take(in);
    in.finish();
}

} // namespace crn
