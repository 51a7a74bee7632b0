// Renames several pending files to their final names together: see pending_file.hpp.
#include "host/base/pending_file.hpp"
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <unistd.h>

namespace crn
{

namespace
{

namespace fs = std::filesystem;

// While an object of the class SignalsWait exists, no signal can end the program between two renames.
class SignalsWait
{
  public:
    SignalsWait()
    {
        sigset_t ending;
        ::sigemptyset(&ending);
        for (int number : {SIGINT, SIGTERM, SIGHUP}) ::sigaddset(&ending, number);
        ::pthread_sigmask(SIG_BLOCK, &ending, &before_);
    }
    ~SignalsWait() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
    SignalsWait(const SignalsWait &) = delete;
    SignalsWait &operator=(const SignalsWait &) = delete;

  private:
    sigset_t before_;
};

// Keeps the previous file of a name while a new file gets this name. The previous file is kept under another
// name until all new files have been renamed.
class Former
{
  public:
    explicit Former(const std::string &path) : path_(path)
    {
        std::error_code failed;
        if (!fs::exists(path, failed)) return;
        const OpenPending kept = open_pending(path); // a name that is free
        ::close(kept.file);
        ::unlink(kept.name.c_str());
        kept_ = kept.name;
        const std::string named = fs::canonical(path, failed).string();
        if (::link(named.c_str(), kept_.c_str()) == 0) return;
        // On a file system without hard links the previous file is renamed, so for a moment there is no file
        // with the final name.
        const int moved = std::rename(named.c_str(), kept_.c_str());
        const int error_number = errno;
        forget_pending(kept_); // it is the only copy now
        if (moved != 0) throw OutputError(path, error_number);
    }

    void bring_back() noexcept
    {
        std::error_code failed;
        const fs::path named = fs::weakly_canonical(path_, failed);
        if (kept_.empty())
            ::unlink(named.c_str());
        else
            std::rename(kept_.c_str(), named.c_str());
        forget_pending(kept_);
    }
    void drop() noexcept
    {
        if (!kept_.empty()) discard_pending(kept_);
    }

  private:
    std::string path_, kept_;
};

} // namespace

void FileSet::add(const std::string &path, std::string_view bytes)
{
    files_.push_back(std::make_unique<PendingFile>(path));
    files_.back()->write(bytes);
    files_.back()->close();
}

void FileSet::commit()
{
    const SignalsWait wait;
    std::vector<Former> former;
    std::size_t named = 0;
    try {
        for (const auto &file : files_) former.emplace_back(file->path());
        for (; named < files_.size(); ++named) files_[named]->commit();
    } catch (const OutputError &) {
        for (std::size_t i = 0; i < former.size(); ++i) i < named ? former[i].bring_back() : former[i].drop();
        files_.clear();
        throw;
    }
    for (Former &one : former) one.drop();
    files_.clear();
}

} // namespace crn
