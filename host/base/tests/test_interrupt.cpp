// These tests check the following. The first Ctrl-C or SIGTERM only sets a flag. The second signal must
// remove pending files and end the program, even if the parent process had blocked or ignored this signal.
// All programs of this repository use the functions of host/base/interrupt for Ctrl-C and SIGTERM.
#include <csetjmp>
#include <csignal>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <sys/wait.h>
#include <unistd.h>

#include "host/base/interrupt.hpp"
#include "host/base/pending_file.hpp"

extern "C" {
#include <cmocka.h>
}

namespace
{

namespace fs = std::filesystem;

// Starts a program that has a pending file and never checks the flag; `before` sets the signal state that the
// program inherits.
pid_t start_deaf(const std::string &file, void (*before)())
{
    int ends[2];
    assert_int_equal(::pipe(ends), 0);
    const pid_t pid = ::fork();
    if (pid == 0) {
        before();
        crn::watch_for_interrupt();
        crn::PendingFile under_way(file);
        static_cast<void>(!::write(ends[1], "!", 1));
        for (;;) ::pause();
    }
    char byte;
    assert_int_equal(::read(ends[0], &byte, 1), 1);
    ::close(ends[0]);
    ::close(ends[1]);
    return pid;
}

bool is_alive(pid_t pid, int &status)
{
    for (int i = 0; i < 50; i++) {
        if (::waitpid(pid, &status, WNOHANG) == pid) return false;
        ::usleep(2000);
    }
    return true;
}

void expect_second_ends(int first, int second, void (*before)())
{
    const std::string folder =
        fs::temp_directory_path() / ("cournand_interrupt_" + std::to_string(::getpid()));
    fs::create_directories(folder);
    const pid_t pid = start_deaf(folder + "/file", before);
    int status = 0;
    ::kill(pid, first);
    assert_true(is_alive(pid, status));
    ::kill(pid, second);
    for (int i = 0; i < 50 && ::waitpid(pid, &status, WNOHANG) != pid; i++) ::usleep(20000);
    assert_true(WIFSIGNALED(status));
    assert_int_equal(WTERMSIG(status), second);
    assert_true(fs::is_empty(folder));
    fs::remove_all(folder);
}

void the_second_signal_ends_any_program(void **)
{
    for (const int first : {SIGINT, SIGTERM})
        for (const int second : {SIGINT, SIGTERM}) expect_second_ends(first, second, [] {});
}

void what_a_parent_blocked_or_ignored_does_not_matter(void **)
{
    expect_second_ends(SIGINT, SIGINT, [] { std::signal(SIGINT, SIG_IGN); });
    expect_second_ends(SIGTERM, SIGINT, [] {
        sigset_t all;
        ::sigfillset(&all);
        ::pthread_sigmask(SIG_BLOCK, &all, nullptr);
    });
}

// No source file may install a handler of its own for SIGINT or SIGTERM, because the second Ctrl-C might then
// not end the program.
void no_program_has_a_handler_of_its_own(void **)
{
    unsigned files = 0;
    for (const char *root : {"host", "tools", "hil_tests"})
        for (const fs::directory_entry &entry : fs::recursive_directory_iterator(root)) {
            const std::string path = entry.path().string();
            if (!path.ends_with(".cpp") || path.find("/tests/") != std::string::npos) continue;
            if (path == "host/base/interrupt.cpp" || path == "host/base/pending_file.cpp") continue;
            std::ifstream file(path);
            const std::string text{std::istreambuf_iterator<char>(file), {}};
            files++;
            for (const char *taken :
                 {"signal(SIGINT", "signal(SIGTERM", "sigaction(SIGINT", "sigaction(SIGTERM"}) {
                for (std::size_t at = text.find(taken); at != std::string::npos;
                     at = text.find(taken, at + 1)) {
                    // A line of code that restores the default action or ignores the signal does not count as
                    // a handler.
                    const std::string line = text.substr(at, text.find('\n', at) - at);
                    if (line.find("SIG_DFL") == std::string::npos &&
                        line.find("SIG_IGN") == std::string::npos)
                        fail_msg("%s: %s: use host/base/interrupt.hpp", path.c_str(), line.c_str());
                }
            }
        }
    assert_true(files > 100);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(the_second_signal_ends_any_program),
        cmocka_unit_test(what_a_parent_blocked_or_ignored_does_not_matter),
        cmocka_unit_test(no_program_has_a_handler_of_its_own),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
