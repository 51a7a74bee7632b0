// Writes pictures as files: PNG, and MP4 through the ffmpeg program.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace crn
{

// 8-bit grey or RGB, row 0 on top.
struct Image {
    int width = 0;
    int height = 0;
    int channels = 1; // 1 or 3
    std::vector<std::uint8_t> bytes;
};

// Writes beside the wanted name and renames at the end, so that the name never refers to half a file. On
// failure it returns false with a message that names the file and the cause.
bool write_png(const std::string &path, const Image &image, std::string &error);
// Encodes a PNG in memory. Throws std::runtime_error with the cause.
std::vector<std::uint8_t> encode_png(const Image &image);
// Writes grey with 16 bits per pixel: unchanged values, width*height, row 0 on top.
bool write_png16(const std::string &path, int width, int height, const std::vector<std::uint16_t> &values,
                 std::string &error);

// Writes H.264 in yuv420p; every picture is RGB of the same even size. The file gets its name only after a
// successful finish(), and the destructor removes an unfinished one. After SIGKILL "name.partPID-RANDOM"
// stays, never a half "name", and ffmpeg ends with us. Open it in the thread that lives longest, because the
// kernel ends ffmpeg when that thread ends.
class VideoWriter
{
  public:
    VideoWriter() = default;
    ~VideoWriter();
    VideoWriter(const VideoWriter &) = delete;
    VideoWriter &operator=(const VideoWriter &) = delete;

    // All three return false on failure, with a message that gives the cause and the remedy.
    bool open(const std::string &path, int width, int height, int pictures_per_s, std::string &error);
    bool add(const Image &image, std::string &error);
    bool finish(std::string &error);
    bool is_open() const { return pipe_ >= 0; }

  private:
    bool fail(const std::string &what, std::string &error);
    void stop();
    bool start(int output, int pictures_per_s);
    std::string path_, unfinished_;
    int width_ = 0, height_ = 0;
    int pipe_ = -1, log_ = -1;
    int process_ = -1;
};

} // namespace crn
