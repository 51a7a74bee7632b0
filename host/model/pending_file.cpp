#include "host/model/pending_file.hpp"
#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <unistd.h>

namespace seld
{

namespace
{

namespace fs = std::filesystem;

// Read by signal handlers: a place is filled before it is marked as taken.
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

// A program that has its own handler calls remove_pending() itself.
void handle_signals()
{
    for (int number : {SIGINT, SIGTERM, SIGHUP}) {
        struct sigaction present {
        };
        if (::sigaction(number, nullptr, &present) == 0 && present.sa_handler == SIG_DFL)
            std::signal(number, on_signal);
    }
    // A file over the user's limit is an error with a message, not the end of the program.
    std::signal(SIGXFSZ, SIG_IGN);
}

std::string reason(int error_number)
{
    switch (error_number) {
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

// The file that a chain of links ends at: renaming onto a link would replace the link.
fs::path end_of_links(const std::string &path)
{
    std::error_code failed;
    if (!fs::is_symlink(fs::symlink_status(path, failed))) return path;
    const fs::path target = fs::weakly_canonical(path, failed);
    return failed ? fs::path(path) : target;
}

} // namespace

OutputError::OutputError(const std::string &path, int error_number)
    : std::runtime_error(path + ": cannot be written: " + std::strerror(error_number) + reason(error_number))
{
}

std::string pending_path(const std::string &path)
{
    std::error_code failed;
    const fs::file_status status = fs::status(path, failed);
    if (fs::is_directory(status)) throw OutputError(path + ": is a folder: name a file to write");
    if (fs::exists(status) && !fs::is_regular_file(status))
        throw OutputError(path + ": is a device or pipe: name a regular file to write");
    return end_of_links(path).string() + ".part" + std::to_string(::getpid());
}

void commit_pending(const std::string &pending, const std::string &path)
{
    if (std::rename(pending.c_str(), end_of_links(path).c_str()) != 0) {
        const int error_number = errno;
        ::unlink(pending.c_str());
        forget_pending(pending);
        throw OutputError(path, error_number);
    }
    forget_pending(pending);
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

void forget_pending(const std::string &pending)
{
    for (Place &place : places)
        if (place.is_taken && pending == place.path) place.is_taken = false;
}

void remove_pending() noexcept
{
    for (Place &place : places)
        if (place.is_taken) ::unlink(place.path);
}

PendingFile::PendingFile(const std::string &path) : path_(path), pending_(pending_path(path))
{
    watch_pending(pending_);
    stream_ = std::fopen(pending_.c_str(), "wb");
    if (stream_) return;
    const int error_number = errno;
    forget_pending(pending_);
    throw OutputError(path, error_number);
}

PendingFile::~PendingFile()
{
    if (!stream_) return;
    std::fclose(stream_);
    ::unlink(pending_.c_str());
    forget_pending(pending_);
}

void PendingFile::write(const void *bytes, std::size_t count)
{
    if (std::fwrite(bytes, 1, count, stream_) != count) throw OutputError(path_, errno);
}

void PendingFile::commit()
{
    if (std::fflush(stream_) != 0) throw OutputError(path_, errno);
    // A disk over the network may tell only now that it is full.
    const int closed = std::fclose(stream_);
    const int error_number = errno;
    stream_ = nullptr;
    if (closed != 0) {
        ::unlink(pending_.c_str());
        forget_pending(pending_);
        throw OutputError(path_, error_number);
    }
    commit_pending(pending_, path_);
}

void write_whole_file(const std::string &path, std::string_view bytes)
{
    PendingFile file(path);
    file.write(bytes);
    file.commit();
}

} // namespace seld
