#include "host/base/pending_file.hpp"
#include "host/base/number_text.hpp"
#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <sys/random.h>
#include <unistd.h>

namespace crn
{

namespace
{

namespace fs = std::filesystem;

// Signal handlers read this list of pending files, so each entry is filled before it is marked as used.
struct Place {
    std::atomic<bool> is_taken = false;
    char path[PATH_MAX] = {};
};
Place places[pending_max];
static_assert(std::atomic<bool>::is_always_lock_free);

void on_signal(int number)
{
    remove_pending();
    std::signal(number, SIG_DFL);
    std::raise(number);
}

// Signal handlers are installed only for signals that still have the default action. A program with signal
// handlers of its own must call remove_pending() from these handlers.
void handle_signals()
{
    for (int number : {SIGINT, SIGTERM, SIGHUP}) {
        struct sigaction present {
        };
        if (::sigaction(number, nullptr, &present) == 0 && present.sa_handler == SIG_DFL)
            std::signal(number, on_signal);
    }
    // If the program writes beyond the user's limit on file sizes, the write must fail with an error and a
    // message; otherwise the signal SIGXFSZ would end the program.
    std::signal(SIGXFSZ, SIG_IGN);
}

std::string reason(int error_number)
{
    switch (error_number) {
    case ENAMETOOLONG:
        return "; give it a shorter name";
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
        return "; make room on the disk or name another folder";
    case ENOENT:
    case ENOTDIR:
        return "; check that the folder exists";
    case EACCES:
    case EPERM:
    case EROFS:
        return "; name a folder that you may write to";
    default:
        return "";
    }
}

// Returns the file at the end of a chain of symbolic links, because renaming a file onto a link would replace
// the link.
fs::path end_of_links(const std::string &path)
{
    std::error_code failed;
    if (!fs::is_symlink(fs::symlink_status(path, failed))) return path;
    const fs::path target = fs::weakly_canonical(path, failed);
    return failed ? fs::path(path) : target;
}

// Returns "path.part1234-9f3a60c2d81b". The process number in the file name identifies the program that made
// the file, and nobody can guess the random digits. A file name that would become too long is cut at its end.
std::string pending_name(const fs::path &path)
{
    std::uint64_t random = 0;
    if (::getentropy(&random, sizeof random) != 0) throw OutputError(path.string(), errno);
    const std::string ending = ".part" + std::to_string(::getpid()) + "-" + hex_text(random >> 16, 12);
    const std::size_t room = NAME_MAX - ending.size();
    return (path.parent_path() / (path.filename().string().substr(0, room) + ending)).string();
}

// Throws OutputError when the path is a folder, a device or a pipe, because the final rename would put a
// regular file in its place.
void check_kind(const std::string &path)
{
    std::error_code failed;
    const fs::file_status status = fs::status(path, failed);
    if (path.empty()) throw OutputError("an output has an empty name: name a file to write");
    if (fs::is_directory(status)) throw OutputError(path + ": is a folder: name a file to write");
    if (fs::exists(status) && !fs::is_regular_file(status))
        throw OutputError(path + ": is a device or pipe: name a regular file to write");
}

// Flushes the written bytes of a file or folder to the disk. Some file systems cannot flush, and this does
// not count as an error.
int sync_path(const std::string &path, int flags)
{
    const int file = ::open(path.c_str(), flags | O_CLOEXEC);
    if (file < 0) return errno;
    const bool failed = ::fsync(file) != 0 && errno != EINVAL && errno != ENOTSUP && errno != EROFS;
    const int error_number = failed ? errno : 0;
    ::close(file);
    return error_number;
}

int sync_file(const std::string &path)
{
    return sync_path(path, O_RDONLY | O_NOFOLLOW);
}

// Flushes the folder's list of names; without this step, the previous file might be back under its name after
// a crash of the machine. A folder that is writable but not readable cannot be flushed, and this failure is
// ignored.
void sync_folder_of(const fs::path &path)
{
    const fs::path folder = path.parent_path();
    sync_path(folder.empty() ? "." : folder.string(), O_RDONLY | O_DIRECTORY);
}

} // namespace

OutputError::OutputError(const std::string &path, int error_number)
    : std::runtime_error(path + ": cannot be written: " + std::strerror(error_number) + reason(error_number))
{
}

OpenPending open_pending(const std::string &path, const std::string &ending)
{
    check_kind(path);
    const fs::path beside = end_of_links(path);
    for (;;) {
        const std::string name = pending_name(beside) + ending;
        watch_pending(name);
        const int file =
            ::open(name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666); // and the umask
        if (file >= 0) return {name, file};
        const int error_number = errno;
        forget_pending(name);
        if (error_number != EEXIST && error_number != EINTR) throw OutputError(path, error_number);
    }
}

void probe_output(const std::string &path)
{
    const OpenPending probe = open_pending(path);
    ::close(probe.file);
    discard_pending(probe.name);
}

void discard_pending(const std::string &pending) noexcept
{
    ::unlink(pending.c_str());
    forget_pending(pending);
}

void commit_pending(const std::string &pending, const std::string &path, bool keeps_unsynced)
{
    const fs::path named = end_of_links(path);
    int error_number = sync_file(pending);
    if (keeps_unsynced) error_number = 0;
    if (error_number == 0 && std::rename(pending.c_str(), named.c_str()) != 0) error_number = errno;
    if (error_number != 0) {
        discard_pending(pending);
        throw OutputError(path, error_number);
    }
    forget_pending(pending);
    sync_folder_of(named);
}

void watch_pending(const std::string &pending)
{
    handle_signals();
    if (pending.size() >= PATH_MAX) return;
    for (Place &place : places) {
        if (place.is_taken) continue;
        std::memcpy(place.path, pending.c_str(), pending.size() + 1);
        place.is_taken = true;
        return;
    }
}

void forget_pending(const std::string &pending) noexcept
{
    for (Place &place : places)
        if (place.is_taken && pending == place.path) place.is_taken = false;
}

void remove_pending() noexcept
{
    for (Place &place : places)
        if (place.is_taken) ::unlink(place.path);
}

PendingFile::PendingFile(const std::string &path) : path_(path)
{
    const OpenPending opened = open_pending(path);
    pending_ = opened.name;
    stream_ = ::fdopen(opened.file, "wb");
    if (stream_) return;
    const int error_number = errno;
    ::close(opened.file);
    discard_pending(pending_);
    throw OutputError(path, error_number);
}

PendingFile::~PendingFile()
{
    if (stream_) std::fclose(stream_);
    if (!has_name_) discard_pending(pending_);
}

void PendingFile::write(const void *bytes, std::size_t count)
{
    if (std::fwrite(bytes, 1, count, stream_) != count) throw OutputError(path_, errno);
}

void PendingFile::close()
{
    if (!stream_) return;
    if (std::fflush(stream_) != 0) throw OutputError(path_, errno);
    // If a network disk is full, the system may report this error only when the file is closed.
    const int closed = std::fclose(stream_);
    stream_ = nullptr;
    if (closed != 0) throw OutputError(path_, errno);
}

void PendingFile::commit()
{
    close();
    has_name_ = true; // or the file is gone: commit_pending removes a file that gets no name
    commit_pending(pending_, path_);
}

void write_whole_file(const std::string &path, std::string_view bytes)
{
    PendingFile file(path);
    file.write(bytes);
    file.commit();
}

} // namespace crn
