// These tests check the following. A file name never refers to an incomplete file. The new file appears under
// its name only when it is complete, and the previous file keeps the name until then. Errors and signals
// leave no pending file behind. The bytes of a file reach the disk before its final name does. To check the
// order of flush and rename, the test replaces fsync and rename by functions that log their calls.
#include "host/base/pending_file.hpp"
#include "host/base/tests/folder.hpp"
#include <cerrno>
#include <csetjmp>
#include <csignal>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
namespace fs = std::filesystem;

namespace
{
std::vector<std::string> calls; // "sync a.part", "rename a", in order; the part after ".part" is left out
int renames_until_failure = -1;

std::string last_part(const std::string &path)
{
    const std::string name = fs::path(path).filename().string();
    const std::size_t at = name.find(".part");
    return at == name.npos ? name : name.substr(0, at + 5);
}
} // namespace

extern "C" int fsync(int file)
{
    char path[4096] = {};
    const std::string link = "/proc/self/fd/" + std::to_string(file);
    if (readlink(link.c_str(), path, sizeof path - 1) > 0)
        calls.push_back("sync " + (fs::is_directory(path) ? "folder" : last_part(path)));
    return static_cast<int>(syscall(SYS_fsync, file));
}

extern "C" int rename(const char *from, const char *to)
{
    if (renames_until_failure >= 0 && renames_until_failure-- == 0) { // only this call fails
        errno = ENOSPC;
        return -1;
    }
    calls.push_back("rename " + last_part(to));
    return static_cast<int>(syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}

namespace
{

// Each test works in its own folder.
struct Folder : tests::Folder {
    Folder() : tests::Folder("pending") {}
};

std::string text_of(const std::string &path)
{
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

template <class Work> std::string message_of(const Work &work)
{
    try {
        work();
    } catch (const OutputError &error) {
        return error.what();
    }
    return "nothing was thrown";
}

// Runs `work` in a child process and returns the child's status from waitpid.
template <class Work> int status_of_child(const Work &work)
{
    const pid_t child = fork();
    if (child == 0) {
        work();
        _exit(99);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return status;
}

} // namespace

static void a_file_has_its_name_only_when_it_is_whole(void **)
{
    Folder folder;
    std::ofstream(folder.file("a")) << "before";
    {
        PendingFile file(folder.file("a"));
        file.write("after");
        assert_string_equal(text_of(folder.file("a")).c_str(), "before");
        file.commit();
    }
    assert_string_equal(text_of(folder.file("a")).c_str(), "after");
    assert_int_equal(folder.count(), 1);
}

static void a_file_given_up_leaves_nothing(void **)
{
    Folder folder;
    {
        PendingFile file(folder.file("a"));
        file.write("half");
        assert_int_equal(folder.count(), 1);
    }
    assert_int_equal(folder.count(), 0);
}

static void a_link_is_followed_to_its_file(void **)
{
    Folder folder;
    fs::create_directory(folder.file("deep"));
    std::ofstream(folder.file("deep/target")) << "before";
    fs::create_symlink("deep/target", folder.file("link"));
    write_whole_file(folder.file("link"), "after");
    assert_true(fs::is_symlink(folder.file("link")));
    assert_string_equal(text_of(folder.file("deep/target")).c_str(), "after");
}

// Renaming the finished file would replace a device, pipe or folder by a regular file; for root it would even
// replace /dev/null.
static void devices_pipes_and_folders_are_refused_and_stay(void **)
{
    Folder folder;
    assert_int_equal(mkfifo(folder.file("pipe").c_str(), 0600), 0);
    for (const std::string &path :
         {std::string("/dev/null"), std::string("/dev/full"), folder.file("pipe")}) {
        const std::string said = message_of([&] { write_whole_file(path, "x"); });
        assert_true(said.find("is a device or pipe: name a regular file") != said.npos);
    }
    assert_true(fs::is_character_file("/dev/null") && fs::is_fifo(folder.file("pipe")));
    const std::string said = message_of([&] { write_whole_file(folder.path, "x"); });
    assert_true(said.find("is a folder") != said.npos);
    fs::create_symlink("/dev/null", folder.file("link"));
    assert_true(message_of([&] { write_whole_file(folder.file("link"), "x"); }).find("is a device") !=
                said.npos);
}

static void a_folder_that_is_missing_is_told(void **)
{
    Folder folder;
    const std::string said = message_of([&] { write_whole_file(folder.file("no/a"), "x"); });
    assert_string_equal(
        said.c_str(),
        (folder.file("no/a") + ": cannot be written: No such file or directory; check that the folder exists")
            .c_str());
}

// The process may write only 1,000 bytes into a file, so the system refuses 2,000 bytes, as it does on a full
// disk.
static void a_full_disk_is_told_and_leaves_what_was_there(void **)
{
    Folder folder;
    std::ofstream(folder.file("a")) << "before";
    const int status = status_of_child([&] {
        const struct rlimit small = {1000, 1000};
        setrlimit(RLIMIT_FSIZE, &small);
        const std::string said =
            message_of([&] { write_whole_file(folder.file("a"), std::string(2000, 'x')); });
        _exit(said.find("make room on the disk") != said.npos ? 7 : 8);
    });
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 7);
    assert_int_equal(folder.count(), 1);
    assert_string_equal(text_of(folder.file("a")).c_str(), "before");
}

static void a_signal_ends_the_program_and_leaves_nothing(void **)
{
    Folder folder;
    for (int number : {SIGINT, SIGTERM, SIGHUP}) {
        const int status = status_of_child([&] {
            std::signal(number, SIG_DFL); // nohup passes a hang-up on as ignored
            PendingFile one(folder.file("a")), two(folder.file("b"));
            one.write("half");
            two.write("half");
            if (folder.count() != 2) _exit(1);
            raise(number);
        });
        assert_true(WIFSIGNALED(status));
        assert_int_equal(WTERMSIG(status), number);
        assert_int_equal(folder.count(), 0);
    }
}

static void a_signal_leaves_the_files_that_are_whole(void **)
{
    Folder folder;
    status_of_child([&] {
        write_whole_file(folder.file("a"), "whole");
        PendingFile half(folder.file("b"));
        raise(SIGTERM);
    });
    assert_int_equal(folder.count(), 1);
    assert_string_equal(text_of(folder.file("a")).c_str(), "whole");
}

// In this test another user of the folder has created a link under a name that can be guessed. The program
// must neither follow the other user's link nor empty the file to which the link points.
static void a_planted_link_is_not_followed(void **)
{
    Folder folder;
    std::ofstream(folder.file("victim")) << "precious";
    fs::create_symlink("victim", folder.file("a.part" + std::to_string(getpid())));
    write_whole_file(folder.file("a"), "after");
    assert_string_equal(text_of(folder.file("victim")).c_str(), "precious");
    assert_string_equal(text_of(folder.file("a")).c_str(), "after");
    assert_false(fs::is_symlink(folder.file("a")));
}

static void two_files_under_way_to_one_name_do_not_meet(void **)
{
    Folder folder;
    PendingFile one(folder.file("a")), two(folder.file("a"));
    one.write("one");
    two.write("the second");
    assert_int_equal(folder.count(), 2);
    one.commit();
    assert_string_equal(text_of(folder.file("a")).c_str(), "one");
    two.commit();
    assert_string_equal(text_of(folder.file("a")).c_str(), "the second");
    assert_int_equal(folder.count(), 1);
}

// A file name has at most 255 bytes, and the pending file's temporary name must not be longer.
static void the_longest_name_can_be_written(void **)
{
    Folder folder;
    write_whole_file(folder.file(std::string(255, 'n')), "x");
    assert_int_equal(folder.count(), 1);
    const std::string said = message_of([&] { write_whole_file(folder.file(std::string(256, 'n')), "x"); });
    assert_true(said.find("shorter name") != said.npos);
    assert_int_equal(folder.count(), 1);
}

static void the_umask_decides_who_may_read(void **)
{
    Folder folder;
    const mode_t before = umask(027);
    write_whole_file(folder.file("a"), "x");
    umask(before);
    assert_int_equal(static_cast<int>(fs::status(folder.file("a")).permissions()), 0640);
}

static void bytes_are_on_the_disk_before_their_name_is(void **)
{
    Folder folder;
    calls.clear();
    write_whole_file(folder.file("a"), "x");
    const std::vector<std::string> wanted = {"sync a.part", "rename a", "sync folder"};
    assert_true(calls == wanted);
}

static void files_of_a_set_get_their_names_together(void **)
{
    Folder folder;
    std::ofstream(folder.file("a")) << "old a";
    FileSet set;
    set.add(folder.file("a"), "new a");
    set.add(folder.file("b"), "new b");
    assert_string_equal(text_of(folder.file("a")).c_str(), "old a");
    assert_false(fs::exists(folder.file("b")));
    set.commit();
    assert_string_equal(text_of(folder.file("a")).c_str(), "new a");
    assert_string_equal(text_of(folder.file("b")).c_str(), "new b");
    assert_int_equal(folder.count(), 2);
}

// When the disk becomes full between two renames, the first rename is undone, whether or not a file existed
// under that name before.
static void a_set_whose_second_name_fails_is_taken_back(void **)
{
    for (bool is_new : {false, true}) {
        Folder folder;
        if (!is_new) std::ofstream(folder.file("a")) << "old a";
        if (!is_new) std::ofstream(folder.file("b")) << "old b";
        FileSet set;
        set.add(folder.file("a"), "new a");
        set.add(folder.file("b"), "new b");
        renames_until_failure = 1;
        const std::string said = message_of([&] { set.commit(); });
        assert_true(said.find(folder.file("b") + ": cannot be written") == 0);
        if (is_new) {
            assert_int_equal(folder.count(), 0);
            continue;
        }
        assert_string_equal(text_of(folder.file("a")).c_str(), "old a");
        assert_string_equal(text_of(folder.file("b")).c_str(), "old b");
        assert_int_equal(folder.count(), 2);
    }
}

static void a_set_that_does_not_fit_the_disk_leaves_what_was_there(void **)
{
    Folder folder;
    std::ofstream(folder.file("a")) << "old a";
    const int status = status_of_child([&] {
        const struct rlimit small = {1000, 1000};
        setrlimit(RLIMIT_FSIZE, &small);
        const std::string said = message_of([&] {
            FileSet set;
            set.add(folder.file("a"), "new a");
            set.add(folder.file("b"), std::string(2000, 'x'));
            set.commit();
        });
        _exit(said.find("make room on the disk") != said.npos ? 7 : 8);
    });
    assert_int_equal(WEXITSTATUS(status), 7);
    assert_int_equal(folder.count(), 1);
    assert_string_equal(text_of(folder.file("a")).c_str(), "old a");
}

static void more_files_than_are_watched_are_written_all_the_same(void **)
{
    Folder folder;
    std::vector<std::unique_ptr<PendingFile>> files;
    for (int i = 0; i < pending_max + 3; i++)
        files.push_back(std::make_unique<PendingFile>(folder.file(std::to_string(i))));
    for (auto &file : files) file->commit();
    assert_int_equal(folder.count(), pending_max + 3);
    // Their entries are free again.
    status_of_child([&] {
        PendingFile half(folder.file("b"));
        raise(SIGTERM);
    });
    assert_int_equal(folder.count(), pending_max + 3);
}

int main()
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_has_its_name_only_when_it_is_whole),
        cmocka_unit_test(a_file_given_up_leaves_nothing),
        cmocka_unit_test(a_link_is_followed_to_its_file),
        cmocka_unit_test(devices_pipes_and_folders_are_refused_and_stay),
        cmocka_unit_test(a_folder_that_is_missing_is_told),
        cmocka_unit_test(a_full_disk_is_told_and_leaves_what_was_there),
        cmocka_unit_test(a_signal_ends_the_program_and_leaves_nothing),
        cmocka_unit_test(a_signal_leaves_the_files_that_are_whole),
        cmocka_unit_test(a_planted_link_is_not_followed),
        cmocka_unit_test(two_files_under_way_to_one_name_do_not_meet),
        cmocka_unit_test(the_longest_name_can_be_written),
        cmocka_unit_test(the_umask_decides_who_may_read),
        cmocka_unit_test(bytes_are_on_the_disk_before_their_name_is),
        cmocka_unit_test(files_of_a_set_get_their_names_together),
        cmocka_unit_test(a_set_whose_second_name_fails_is_taken_back),
        cmocka_unit_test(a_set_that_does_not_fit_the_disk_leaves_what_was_there),
        cmocka_unit_test(more_files_than_are_watched_are_written_all_the_same),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
