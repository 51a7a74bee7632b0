// Writes MP4 files through a pipe into the program ffmpeg. The child process leaves our process group, so
// Ctrl-C reaches only our program. Our program then closes the pipe or removes the file, so that ffmpeg
// always ends in an orderly way. When our program is killed, the kernel kills ffmpeg too. ffmpeg gets the
// file as an open descriptor, and its messages go into memory. So no file name is opened a second time.
#include "host/base/pending_file.hpp"
#include "host/picture/picture.hpp"
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

namespace crn
{
namespace
{

constexpr int exit_no_program = 127;

constexpr int output_of_ffmpeg = 3;

// Between fork and exec the child may make only system calls.
[[noreturn]] void become_ffmpeg(pid_t parent, int input, int output, int log, const char *size,
                                const char *rate)
{
    ::setpgid(0, 0);
    // The parent may have ended before the kernel registered the request, so the child checks its parent
    // afterwards.
    if (::prctl(PR_SET_PDEATHSIG, SIGKILL) != 0 || ::getppid() != parent) ::_exit(1);
    // The copies have descriptor numbers above those now in use, so that no dup2 below closes one of them.
    const int from[] = {::fcntl(input, F_DUPFD_CLOEXEC, 10), ::fcntl(log, F_DUPFD_CLOEXEC, 10),
                        ::fcntl(output, F_DUPFD_CLOEXEC, 10)};
    if (::dup2(from[0], 0) < 0 || ::dup2(from[1], 1) < 0 || ::dup2(from[1], 2) < 0 ||
        ::dup2(from[2], output_of_ffmpeg) < 0)
        ::_exit(1);
    ::execlp("ffmpeg", "ffmpeg", "-hide_banner", "-loglevel", "error", "-nostdin", "-y", "-f", "rawvideo",
             "-pix_fmt", "rgb24", "-video_size", size, "-framerate", rate, "-i", "pipe:0", "-an", "-c:v",
             "libx264", "-preset", "veryfast", "-crf", "20", "-threads", "1", "-pix_fmt", "yuv420p",
             "-movflags", "+faststart", "-f", "mp4", "/dev/fd/3", static_cast<char *>(nullptr));
    ::_exit(exit_no_program);
}

std::string last_line(int log)
{
    constexpr off_t bytes_max = 2000; // counted from its end
    char text[bytes_max];
    struct stat info {
    };
    if (log < 0 || ::fstat(log, &info) != 0) return {};
    const ssize_t count = ::pread(log, text, bytes_max, std::max<off_t>(0, info.st_size - bytes_max));
    std::string last(text, count > 0 ? static_cast<std::size_t>(count) : 0);
    while (!last.empty() && last.back() == '\n') last.pop_back();
    return last.substr(last.rfind('\n') + 1); // npos + 1: the whole text
}

// Opens a block of memory into which a program can write as if it were a file.
int open_log()
{
    return ::memfd_create("ffmpeg's messages", MFD_CLOEXEC);
}

// Writing to a pipe whose reader has died must return an error, and must not end this process.
class IgnoreBrokenPipe
{
  public:
    IgnoreBrokenPipe()
    {
        struct sigaction ignore {
        };
        ignore.sa_handler = SIG_IGN;
        ::sigaction(SIGPIPE, &ignore, &before_);
    }
    ~IgnoreBrokenPipe() { ::sigaction(SIGPIPE, &before_, nullptr); }
    IgnoreBrokenPipe(const IgnoreBrokenPipe &) = delete;
    IgnoreBrokenPipe &operator=(const IgnoreBrokenPipe &) = delete;

  private:
    struct sigaction before_ {
    };
};

} // namespace

VideoWriter::~VideoWriter()
{
    stop();
}

bool VideoWriter::open(const std::string &path, int width, int height, int pictures_per_s, std::string &error)
{
    stop();
    path_ = path;
    width_ = width;
    height_ = height;
    if (width < 16 || height < 16 || width % 2 != 0 || height % 2 != 0 || pictures_per_s < 1) {
        error = path + ": a video needs an even size of 16 or more and at least 1 picture per second";
        return false;
    }
    OpenPending output;
    try {
        output = open_pending(path);
    } catch (const OutputError &refused) {
        error = refused.what();
        return false;
    }
    unfinished_ = output.name;
    const bool is_started = start(output.file, pictures_per_s);
    const int error_number = errno;
    ::close(output.file);
    return is_started || fail("cannot start ffmpeg: " + std::string(std::strerror(error_number)), error);
}

// On failure it returns false and sets errno.
bool VideoWriter::start(int output, int pictures_per_s)
{
    log_ = open_log();
    int ends[2];
    if (log_ < 0 || ::pipe2(ends, O_CLOEXEC) != 0) return false;
    const std::string size = std::to_string(width_) + "x" + std::to_string(height_);
    const std::string rate = std::to_string(pictures_per_s);
    const pid_t parent = ::getpid();
    process_ = ::fork();
    if (process_ == 0) become_ffmpeg(parent, ends[0], output, log_, size.c_str(), rate.c_str());
    const int error_number = errno;
    ::close(ends[0]);
    pipe_ = ends[1];
    errno = error_number;
    return process_ > 0;
}

bool VideoWriter::add(const Image &image, std::string &error)
{
    if (pipe_ < 0) {
        error = path_ + ": the video is not open";
        return false;
    }
    if (image.width != width_ || image.height != height_ || image.channels != 3)
        return fail("a picture has another size than the video", error);
    IgnoreBrokenPipe guard;
    for (std::size_t done = 0; done < image.bytes.size();) {
        const ssize_t count = ::write(pipe_, image.bytes.data() + done, image.bytes.size() - done);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return fail("ffmpeg stopped taking pictures", error);
        done += static_cast<std::size_t>(count);
    }
    return true;
}

bool VideoWriter::finish(std::string &error)
{
    if (pipe_ < 0) {
        error = path_ + ": the video is not open";
        return false;
    }
    ::close(pipe_);
    pipe_ = -1;
    int status = 0;
    while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = -1;
    if (WIFEXITED(status) && WEXITSTATUS(status) == exit_no_program)
        return fail("the program ffmpeg was not found; install it (Debian: apt-get install ffmpeg)", error);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return fail("ffmpeg failed", error);
    try {
        commit_pending(unfinished_, path_);
    } catch (const OutputError &refused) {
        error = refused.what();
        stop();
        return false;
    }
    unfinished_.clear();
    stop();
    return true;
}

// Reports what failed, together with the last line that ffmpeg printed, and removes the unfinished file.
bool VideoWriter::fail(const std::string &what, std::string &error)
{
    int status = 0;
    bool is_missing = false;
    if (pipe_ >= 0) ::close(pipe_);
    pipe_ = -1;
    if (process_ > 0) {
        while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
        }
        is_missing = WIFEXITED(status) && WEXITSTATUS(status) == exit_no_program;
        process_ = -1;
    }
    const std::string said = last_line(log_);
    error =
        path_ + ": " +
        (is_missing ? "the program ffmpeg was not found; install it (Debian: apt-get install ffmpeg)" : what);
    if (!said.empty()) error += " (ffmpeg: " + said + ")";
    stop();
    return false;
}

void VideoWriter::stop()
{
    if (pipe_ >= 0) ::close(pipe_);
    pipe_ = -1;
    if (process_ > 0) {
        ::kill(process_, SIGKILL);
        while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
        }
    }
    process_ = -1;
    if (log_ >= 0) ::close(log_);
    log_ = -1;
    if (!unfinished_.empty()) discard_pending(unfinished_);
    unfinished_.clear();
}

} // namespace crn
