// A file under way: it is written beside the wanted name and gets that name when it is whole, so that a name never stands
// for half a file, and what stood there before is kept until then. May include: nothing. Called by: whoever writes files.
#pragma once
#include <cstdio>
#include <stdexcept>
#include <string>
#include <string_view>

namespace seld
{

// "path: cannot be written: No space left on device; ...": what is wrong, and what to do.
class OutputError : public std::runtime_error
{
  public:
    OutputError(const std::string &path, int error_number);
    using std::runtime_error::runtime_error;
};

// Where a file of this name is written meanwhile: "path.partPID", beside the file that a link leads to. Throws OutputError
// when the name is that of a folder, a device or a pipe: renaming would put a file in their place.
std::string pending_path(const std::string &path);

// Gives what is whole its name. Throws OutputError; what was written is then removed.
void commit_pending(const std::string &pending, const std::string &path);

// Files that must not be left behind: a signal that ends the program (SIGINT, SIGTERM, SIGHUP) removes them first. At
// most pending_max at a time; more are written all the same, but a signal leaves them.
inline constexpr int pending_max = 32;
void watch_pending(const std::string &pending);
void forget_pending(const std::string &pending);
// For the program's own signal handlers: calls unlink and nothing else.
void remove_pending() noexcept;

class PendingFile
{
  public:
    // Throws OutputError when nothing can be written there.
    explicit PendingFile(const std::string &path);
    // Removes what was not committed.
    ~PendingFile();
    PendingFile(const PendingFile &) = delete;
    PendingFile &operator=(const PendingFile &) = delete;

    void write(const void *bytes, std::size_t count); // throws OutputError
    void write(std::string_view text) { write(text.data(), text.size()); }
    // Everything is on its way to the disk, and the file has its name. Throws OutputError.
    void commit();
    const std::string &path() const { return path_; }

  private:
    std::string path_, pending_;
    std::FILE *stream_ = nullptr;
};

// The whole file at once. Throws OutputError.
void write_whole_file(const std::string &path, std::string_view bytes);

} // namespace seld
