#include "host/cases/unpack.hpp"
#include "host/base/pending_file.hpp"
#include <archive.h>
#include <archive_entry.h>
#include <memory>
#include <stdexcept>
#include <string>
#include <unistd.h>
#include <vector>

namespace crn
{

namespace
{

namespace fs = std::filesystem;

constexpr std::size_t block_bytes = 1 << 16;
constexpr std::int64_t file_bytes_max = std::int64_t{256} << 20; // as of a file with bodies (scene.h)

struct Close {
    void operator()(archive *one) const { archive_read_free(one); }
};

[[noreturn]] void refuse(const fs::path &archive, const std::string &cause)
{
    throw std::runtime_error(archive.string() + ": cannot be unpacked: " + cause +
                             "; get the file again, or install the program again");
}

// Holds a temporary folder beside the wanted folder, and removes it unless it was renamed to the wanted
// folder's name.
class PendingFolder
{
  public:
    explicit PendingFolder(const fs::path &wanted) : wanted_(wanted)
    {
        std::error_code failure;
        fs::create_directories(wanted.parent_path(), failure);
        path_ = wanted.string() + ".part-XXXXXX";
        if (failure || !mkdtemp(path_.data()))
            throw std::runtime_error(
                "scenes are unpacked into '" + wanted.parent_path().string() +
                "', where no folder can be made: name another place with XDG_CACHE_HOME");
    }
    ~PendingFolder()
    {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    PendingFolder(const PendingFolder &) = delete;
    PendingFolder &operator=(const PendingFolder &) = delete;
    const std::string &path() const { return path_; }
    void commit() const
    {
        std::error_code failure;
        fs::rename(path_, wanted_, failure);
        // Another program may have unpacked the same archive into the wanted folder in the meantime.
        if (failure && !fs::is_directory(wanted_))
            throw std::runtime_error(wanted_.string() + ": cannot be made: " + failure.message());
    }

  private:
    fs::path wanted_;
    std::string path_;
};

std::string contents(archive *packed, archive_entry *entry, const fs::path &path, const UnpackWatch &goes_on,
                     std::size_t total)
{
    const std::string name = archive_entry_pathname(entry);
    if (archive_entry_filetype(entry) != AE_IFREG || name.find('/') != name.npos ||
        archive_entry_size(entry) > file_bytes_max)
        refuse(path, "'" + name + "' is no file of a scene");
    std::string bytes;
    std::vector<char> block(block_bytes);
    for (;;) {
        const auto count = archive_read_data(packed, block.data(), block.size());
        if (count < 0) refuse(path, archive_error_string(packed));
        if (count == 0) return bytes;
        if (!goes_on(static_cast<std::size_t>(archive_filter_bytes(packed, -1)), total))
            throw std::runtime_error("interrupted: nothing was unpacked");
        bytes.append(block.data(), static_cast<std::size_t>(count));
        if (bytes.size() > static_cast<std::size_t>(file_bytes_max))
            refuse(path, "'" + name + "' is too large");
    }
}

} // namespace

void unpack_scene(const fs::path &path, const fs::path &folder, const UnpackWatch &goes_on)
{
    const std::unique_ptr<archive, Close> packed(archive_read_new());
    archive_read_support_format_tar(packed.get());
    archive_read_support_filter_xz(packed.get());
    if (archive_read_open_filename(packed.get(), path.c_str(), block_bytes) != ARCHIVE_OK)
        refuse(path, archive_error_string(packed.get()));
    const PendingFolder pending(folder);
    std::size_t count = 0;
    for (archive_entry *entry = nullptr;; ++count) {
        const int status = archive_read_next_header(packed.get(), &entry);
        if (status == ARCHIVE_EOF) break;
        if (status != ARCHIVE_OK) refuse(path, archive_error_string(packed.get()));
        const std::string name = archive_entry_pathname(entry);
        write_whole_file(pending.path() + "/" + name,
                         contents(packed.get(), entry, path, goes_on, fs::file_size(path)));
    }
    if (count == 0) refuse(path, "it holds no file");
    pending.commit();
}

} // namespace crn
