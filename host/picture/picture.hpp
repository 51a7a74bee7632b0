// Writes pictures as PNG files, and films as MP4 files with H.264.
#pragma once
#include <cstdint>
#include <exception>
#include <memory>
#include <string>
#include <vector>

namespace crn
{

// Holds a grey or RGB picture with 8 bits per channel; row 0 is the top row.
struct Image {
    int width = 0;
    int height = 0;
    int channels = 1; // 1 or 3
    std::vector<std::uint8_t> bytes;
};

// Writes the picture to a temporary file in the same folder and renames it at the end, so that the wanted
// name never refers to an incomplete file. On failure the function returns false, and `error` names the file
// and the cause.
bool write_png(const std::string &path, const Image &image, std::string &error);
// Reads a PNG file as a grey picture; colours become grey. Throws std::runtime_error with the name of the
// file and the cause.
Image read_grey_png(const std::string &path);
// Encodes a PNG in memory. Throws std::runtime_error with the cause.
std::vector<std::uint8_t> encode_png(const Image &image);
// Writes a grey picture with 16 bits per pixel. `values` holds width*height pixel values, which are stored
// unchanged; row 0 is the top row.
bool write_png16(const std::string &path, int width, int height, const std::vector<std::uint16_t> &values,
                 std::string &error);

class H264Encoder;
class Mp4File;

// Writes a film as H.264 in yuv420p (BT.709); every picture must be RGB and have the same even size. Equal
// pictures always give equal bytes of the film. The file gets its final name only after a successful
// finish(); the destructor deletes an unfinished file. If the program is killed (SIGKILL), a file
// "name.partPID-RANDOM" stays, but no incomplete file "name".
class VideoWriter
{
  public:
    static constexpr int pictures_per_s_max = 60;

    VideoWriter();
    ~VideoWriter();
    VideoWriter(const VideoWriter &) = delete;
    VideoWriter &operator=(const VideoWriter &) = delete;

    // The functions of this class return false on failure, and `error` then gives the cause and the remedy.
    bool open(const std::string &path, int width, int height, int pictures_per_s, std::string &error);
    bool add(const Image &image, std::string &error);
    bool finish(std::string &error);
    bool is_open() const { return file_ != nullptr; }

  private:
    bool fail(const std::exception &failed, std::string &error);
    void stop();
    std::string path_;
    int width_ = 0, height_ = 0, pictures_per_s_ = 0;
    std::unique_ptr<H264Encoder> encoder_;
    std::unique_ptr<Mp4File> file_;
};

} // namespace crn
