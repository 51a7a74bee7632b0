// A pending file is written beside the wanted name and gets that name when it is whole. So a name never
// refers to half a file, and the former file is kept until then.
#pragma once
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace crn
{

// The message is like "path: cannot be written: No space left on device; ...": the cause, and the remedy.
class OutputError : public std::runtime_error
{
  public:
    OutputError(const std::string &path, int error_number);
    using std::runtime_error::runtime_error;
};

// A file beside the wanted one (beside the end of a link) until it is whole: "path.partPID-RANDOM". It did
// not exist before, and no link was followed; signal handlers remove it as described below. `ending` is
// appended to the name, for writers that check it. Throws OutputError; also when the wanted name is empty or
// that of a folder, a device or a pipe.
struct OpenPending {
    std::string name;
    int file; // descriptor for writing, owned by the caller; child processes do not inherit it
};
OpenPending open_pending(const std::string &path, const std::string &ending = "");

// Throws what open_pending would throw, and leaves no file.
void probe_output(const std::string &path);

// Gives a whole and closed file its name: the bytes reach the disk before the name does, and the name reaches
// it before this returns. Throws OutputError; the pending file is then removed. With `keeps_unsynced` a file
// that a full disk could not flush completely still gets its name.
void commit_pending(const std::string &pending, const std::string &path, bool keeps_unsynced = false);
void discard_pending(const std::string &pending) noexcept;

// Files that must not be left behind are listed: a signal that ends the program (SIGINT, SIGTERM, SIGHUP)
// removes them first. There are at most pending_max at a time; further files are written too, but a signal
// leaves them behind.
inline constexpr int pending_max = 32;
void watch_pending(const std::string &pending);
void forget_pending(const std::string &pending) noexcept;
// For the program's own signal handlers: it only calls unlink.
void remove_pending() noexcept;

class PendingFile
{
  public:
    // Throws OutputError when the file cannot be written.
    explicit PendingFile(const std::string &path);
    // Removes the file unless it was committed.
    ~PendingFile();
    PendingFile(const PendingFile &) = delete;
    PendingFile &operator=(const PendingFile &) = delete;

    void write(const void *bytes, std::size_t count); // throws OutputError
    void write(std::string_view text) { write(text.data(), text.size()); }
    // Ends writing, and reports a full disk. Throws OutputError.
    void close();
    // Flushes the file to disk and gives it its name. Throws OutputError.
    void commit();
    const std::string &path() const { return path_; }
    std::FILE *stream() { return stream_; } // for libraries that write by themselves; null after close()

  private:
    std::string path_, pending_;
    std::FILE *stream_ = nullptr;
    bool has_name_ = false;
};

// Files that belong together, such as a scene and its bodies: either all of them get their names, or all
// former files stay.
class FileSet
{
  public:
    // Writes a file beside its name. Throws OutputError.
    void add(const std::string &path, std::string_view bytes);
    // Throws OutputError; names already given are then taken back. Only a program that is killed in between
    // (SIGKILL, a crash of the machine) leaves a mixture, which readers have to detect.
    void commit();

  private:
    std::vector<std::unique_ptr<PendingFile>> files_;
};

// Writes the whole file at once. Throws OutputError.
void write_whole_file(const std::string &path, std::string_view bytes);

} // namespace crn
