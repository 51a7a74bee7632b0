// An output file is written as a pending file beside its final name, and is renamed when it is complete.
// Therefore the final name never refers to an incomplete file, and the previous file is kept until the
// rename.
#pragma once
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace crn
{

// The message of an OutputError names the cause and the remedy, for example "path: cannot be written: No
// space left on device; ...".
class OutputError : public std::runtime_error
{
  public:
    OutputError(const std::string &path, int error_number);
    using std::runtime_error::runtime_error;
};

// Opens a pending file "path.partPID-RANDOM" beside the file `path`. If `path` is a link, the pending file is
// beside the file to which the link leads. The pending file keeps this temporary name until it is complete.
// The pending file is always a new file: if a link with this name exists, the program does not write to the
// file behind the link. Signal handlers remove the pending file when a signal ends the program, as described
// below. `ending` is appended to the temporary name, for libraries that check a file's extension. Throws
// OutputError if the file cannot be created, and also if `path` is empty or names a folder, a device or a
// pipe.
struct OpenPending {
    std::string name;
    int file; // descriptor for reading and writing, owned by the caller; child processes do not inherit it
};
OpenPending open_pending(const std::string &path, const std::string &ending = "");

// Throws the exceptions that open_pending would throw for this path, and leaves no file behind.
void probe_output(const std::string &path);

// Renames a complete, closed pending file to its final name. The bytes of the file reach the disk before its
// name does, and the name reaches the disk before this function returns. On failure the function removes the
// pending file and throws OutputError. If `keeps_unsynced` is true, the function renames the pending file
// even if a full disk prevented the flush.
void commit_pending(const std::string &pending, const std::string &path, bool keeps_unsynced = false);
void discard_pending(const std::string &pending) noexcept;

// The program keeps a list of its pending files. If a signal (SIGINT, SIGTERM, SIGHUP) ends the program, the
// signal handler first removes the listed files. The list has pending_max entries. The program may have more
// pending files than the list has entries, but a signal does not remove the files that are not in the list.
inline constexpr int pending_max = 32;
void watch_pending(const std::string &pending);
void forget_pending(const std::string &pending) noexcept;
// Removes the listed files. The program's own signal handlers may call remove_pending(), because it only
// calls unlink.
void remove_pending() noexcept;

class PendingFile
{
  public:
    // Throws OutputError when the pending file cannot be written.
    explicit PendingFile(const std::string &path);
    // Removes the pending file unless it was committed.
    ~PendingFile();
    PendingFile(const PendingFile &) = delete;
    PendingFile &operator=(const PendingFile &) = delete;

    void write(const void *bytes, std::size_t count); // throws OutputError
    void write(std::string_view text) { write(text.data(), text.size()); }
    // Closes the pending file, and throws OutputError when the disk is full.
    void close();
    // Flushes the pending file to disk and renames it to its final name. Throws OutputError.
    void commit();
    const std::string &path() const { return path_; }
    std::FILE *stream() { return stream_; } // for libraries that write by themselves; null after close()

  private:
    std::string path_, pending_;
    std::FILE *stream_ = nullptr;
    bool has_name_ = false;
};

// Writes files that belong together, such as a scene and its bodies. Either all new files get their final
// names, or all previous files stay.
class FileSet
{
  public:
    // Writes a pending file beside its final name. Throws OutputError.
    void add(const std::string &path, std::string_view bytes);
    // On failure the function throws OutputError. After a failure the function undoes the renames already
    // made, so that the previous files are back under their names. A mixture of old and new files can remain
    // only if the program dies between two renames (SIGKILL, or a crash of the machine). Programs that read
    // these files have to detect a mixture of old and new files.
    void commit();

  private:
    std::vector<std::unique_ptr<PendingFile>> files_;
};

// Writes the whole content of a file at once. Throws OutputError.
void write_whole_file(const std::string &path, std::string_view bytes);

} // namespace crn
