// Tests the records after a crash: if a program is killed at random moments or its disk is full, no session
// reported as stored is lost, and none is stored in part.
#include "host/base/tests/folder.hpp"
#include "host/records/store.hpp"
#include "host/records/tests/sample_records.hpp"
#include <csetjmp>
#include <csignal>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
extern "C" {
#include <cmocka.h>
}

namespace
{

using namespace crn;

constexpr int kills = 25, sessions_per_child = 1000;
constexpr unsigned seed = 1;

// The child process runs `work`, which writes the number of each stored session into the pipe. Returns the
// last number in the pipe, after the child process has ended; `while_it_runs` receives the child's process
// id.
int last_stored(const std::function<void(int pipe)> &work, const std::function<void(pid_t)> &while_it_runs,
                int before)
{
    int ends[2];
    assert_int_equal(::pipe(ends), 0);
    const pid_t child = ::fork();
    assert_true(child >= 0);
    if (child == 0) {
        ::close(ends[0]);
        work(ends[1]);
        ::_exit(0);
    }
    ::close(ends[1]);
    while_it_runs(child);
    int last = before, number;
    while (::read(ends[0], &number, sizeof number) == sizeof number) last = number;
    ::close(ends[0]);
    int status;
    assert_true(::waitpid(child, &status, 0) == child);
    return last;
}

void report(int pipe, int number)
{
    if (::write(pipe, &number, sizeof number) != sizeof number) ::_exit(9);
}

// Checks that every session up to `last` is stored, and that every stored session has all of its parts.
void assert_whole(RecordStore &store, int last, const char *after)
{
    assert_int_equal(store.faults().size(), 0);
    const std::vector<SessionRecord> sessions = store.sessions({});
    std::printf("# %s: %zu sessions, %d reported\n", after, sessions.size(), last + 1);
    // One more session may be stored if the child was killed before it could report that session.
    assert_true(static_cast<int>(sessions.size()) >= last + 1 &&
                static_cast<int>(sessions.size()) <= last + 2);
    for (std::size_t i = 0; i < sessions.size(); i++) {
        assert_string_equal(sessions[i].id.c_str(), sample_record("otter", static_cast<int>(i)).id.c_str());
        assert_int_equal(sessions[i].metrics.size(), 3);
        assert_int_equal(sessions[i].events.size(), 4);
        assert_int_equal(sessions[i].score->parts.size(), 2);
    }
    assert_int_equal(store.outbox().size(), sessions.size());
}

void a_killed_program_loses_no_stored_session(void **)
{
    const tests::Folder folder("records");
    const std::string path = folder.file("records.db");
    std::mt19937 random(seed);
    std::printf("# seed %u\n", seed);
    int last = -1;
    // On a slow machine more rounds are needed until the child processes have stored some sessions.
    for (int round = 0; round < kills || (last <= kills && round < 40 * kills); round++) {
        const unsigned wait_us = 3000 + static_cast<unsigned>(random() % 100000);
        last = last_stored(
            [&](int pipe) {
                RecordStore store = open_store(path);
                for (int i = last + 1; i < last + sessions_per_child; i++) {
                    store.save(sample_record("otter", i));
                    report(pipe, i);
                }
            },
            [&](pid_t child) {
                ::usleep(wait_us);
                ::kill(child, SIGKILL);
            },
            last);
        RecordStore store = open_store(path);
        assert_whole(store, last, "after SIGKILL");
        last = static_cast<int>(store.sessions({}, false).size()) - 1;
    }
    assert_true(last > kills); // the children did store sessions
}

// A limit on the size of files simulates the full disk: the write call fails in the same way, with EFBIG
// instead of ENOSPC.
void a_full_disk_is_reported_and_harms_nothing(void **)
{
    const tests::Folder folder("records");
    const std::string path = folder.file("records.db");
    open_store(path).save(sample_record("otter", 0));
    int last = 0;
    for (rlim_t limit_kB : {300, 400, 555, 800}) {
        bool was_full = false;
        last = last_stored(
            [&](int pipe) {
                std::signal(SIGXFSZ, SIG_IGN);
                const rlimit limit{limit_kB << 10, limit_kB << 10};
                ::setrlimit(RLIMIT_FSIZE, &limit);
                try {
                    RecordStore store = open_store(path);
                    for (int i = last + 1; i < last + sessions_per_child; i++) {
                        store.save(sample_record("otter", i));
                        report(pipe, i);
                    }
                } catch (const RecordsError &error) {
                    const std::string text = error.what();
                    const bool is_clear = error.cause == RecordsError::Cause::no_space &&
                                          text.find(path) != text.npos &&
                                          text.find("Free some space") != text.npos;
                    if (!is_clear) std::fprintf(stderr, "# %s\n", text.c_str());
                    ::_exit(is_clear ? 7 : 8);
                }
            },
            [&](pid_t child) {
                siginfo_t info;
                assert_int_equal(::waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOWAIT), 0);
                was_full = info.si_status == 7;
            },
            last);
        assert_true(was_full);
        RecordStore store = open_store(path);
        assert_whole(store, last, "after a full disk");
        store.save(sample_record("otter", ++last)); // there is room again
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_killed_program_loses_no_stored_session),
        cmocka_unit_test(a_full_disk_is_reported_and_harms_nothing),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
