// MP4 by a pipe into the ffmpeg program. The child leaves our process group: Ctrl-C reaches only us, we close the pipe
// or remove the file, so that ffmpeg always finishes in an orderly way.
#include "host/app/picture.hpp"
#include "host/model/pending_file.hpp"
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <sys/wait.h>
#include <unistd.h>

namespace seld
{
namespace
{

constexpr int exit_no_program = 127;

[[noreturn]] void become_ffmpeg(int input, const std::string &log, const char *size, const char *rate,
                                const char *output)
{
    ::setpgid(0, 0);
    const int messages = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (messages < 0 || ::dup2(input, 0) < 0 || ::dup2(messages, 1) < 0 || ::dup2(messages, 2) < 0)
        ::_exit(1);
    ::execlp("ffmpeg", "ffmpeg", "-hide_banner", "-loglevel", "error", "-nostdin", "-y", "-f", "rawvideo",
             "-pix_fmt", "rgb24", "-video_size", size, "-framerate", rate, "-i", "pipe:0", "-an", "-c:v",
             "libx264", "-preset", "veryfast", "-crf", "20", "-threads", "1", "-pix_fmt", "yuv420p",
             "-movflags", "+faststart", "-f", "mp4", output, static_cast<char *>(nullptr));
    ::_exit(exit_no_program);
}

std::string last_line(const std::string &path)
{
    std::ifstream file(path);
    std::string line, last;
    while (std::getline(file, line))
        if (!line.empty()) last = line;
    return last;
}

// Writing to a pipe whose reader died must be an error, not the end of this process.
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
    try {
        unfinished_ = pending_path(path);
    } catch (const OutputError &refused) {
        error = refused.what();
        return false;
    }
    log_ = unfinished_ + ".log";
    if (width < 16 || height < 16 || width % 2 != 0 || height % 2 != 0 || pictures_per_s < 1) {
        error = path + ": a video needs an even size of 16 or more and at least 1 picture per second";
        return false;
    }
    std::FILE *probe = std::fopen(unfinished_.c_str(), "wb");
    if (!probe) {
        error = path + ": cannot write here: " + std::strerror(errno) + "; check that the folder exists";
        return false;
    }
    std::fclose(probe);
    watch_pending(unfinished_);
    watch_pending(log_);
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0)
        return fail("cannot make a pipe: " + std::string(std::strerror(errno)), error);
    const std::string size = std::to_string(width) + "x" + std::to_string(height);
    const std::string rate = std::to_string(pictures_per_s);
    process_ = ::fork();
    if (process_ == 0) become_ffmpeg(ends[0], log_, size.c_str(), rate.c_str(), unfinished_.c_str());
    ::close(ends[0]);
    pipe_ = ends[1];
    if (process_ < 0) return fail("cannot start ffmpeg: " + std::string(std::strerror(errno)), error);
    return true;
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
    ::unlink(log_.c_str());
    forget_pending(log_);
    return true;
}

// Says what happened, with ffmpeg's own last line, and removes what is unfinished.
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
    if (unfinished_.empty()) return;
    ::unlink(unfinished_.c_str());
    ::unlink(log_.c_str());
    forget_pending(unfinished_);
    forget_pending(log_);
    unfinished_.clear();
}

} // namespace seld
