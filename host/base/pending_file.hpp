// A file under way: it is written beside the wanted name and gets that name when it is whole, so that a name
// never stands for half a file, and what stood there before is kept until then.
#pragma once
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace crn
{

// "path: cannot be written: No space left on device; ...": what is wrong, and what to do.
class OutputError : public std::runtime_error
{
  public:
    OutputError(const std::string &path, int error_number);
    using std::runtime_error::runtime_error;
};

// A file that stands beside the one that is wanted (beside the end of a link) until it is whole:
// "path.partPID-RANDOM". It did not exist before and no link was followed; it is watched as below. `ending`
// goes behind the name, for writers that look at it. Throws OutputError; also when the wanted name is empty
// or that of a folder, a device or a pipe.
struct OpenPending {
    std::string name;
    int file; // descriptor to write to, the caller's; programs that are started do not inherit it
};
OpenPending open_pending(const std::string &path, const std::string &ending = "");

// Throws what open_pending would throw, and leaves nothing.
void probe_output(const std::string &path);

// Gives what is whole and closed its name: the bytes reach the disk before the name does, and the name before
// this returns. Throws OutputError; what was written is then removed. `keeps_unsynced`: what a full disk
// holds of it is worth its name.
void commit_pending(const std::string &pending, const std::string &path, bool keeps_unsynced = false);
void discard_pending(const std::string &pending) noexcept;

// Files that must not be left behind: a signal that ends the program (SIGINT, SIGTERM, SIGHUP) removes them
// first. At most pending_max at a time; more are written all the same, but a signal leaves them.
inline constexpr int pending_max = 32;
void watch_pending(const std::string &pending);
void forget_pending(const std::string &pending) noexcept;
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
    // Nothing more is written; full disks are told. Throws OutputError.
    void close();
    // Everything is on the disk, and the file has its name. Throws OutputError.
    void commit();
    const std::string &path() const { return path_; }
    std::FILE *stream() { return stream_; } // for libraries that write by themselves; null after close()

  private:
    std::string path_, pending_;
    std::FILE *stream_ = nullptr;
    bool has_name_ = false;
};

// Files that belong together, such as a scene and its bodies: they all get their names, or what stood there
// stays.
class FileSet
{
  public:
    // Writes it beside its name. Throws OutputError.
    void add(const std::string &path, std::string_view bytes);
    // Throws OutputError; names that were given are then taken back. Only a program that is killed in between
    // (SIGKILL, a crash of the machine) leaves some of each: whoever reads them has to find that out.
    void commit();

  private:
    std::vector<std::unique_ptr<PendingFile>> files_;
};

// The whole file at once. Throws OutputError.
void write_whole_file(const std::string &path, std::string_view bytes);

} // namespace crn
