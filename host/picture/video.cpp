// Writes a film that the library openh264 encodes as H.264, in an MP4 file that the project's own code
// writes.
#include "host/picture/h264.hpp"
#include "host/picture/mp4_file.hpp"
#include "host/picture/picture.hpp"

namespace crn
{

VideoWriter::VideoWriter() = default;

VideoWriter::~VideoWriter() = default;

bool VideoWriter::open(const std::string &path, int width, int height, int pictures_per_s, std::string &error)
{
    stop();
    path_ = path;
    width_ = width;
    height_ = height;
    pictures_per_s_ = pictures_per_s;
    const auto fits = [](int edge) { return edge >= 16 && edge <= H264Encoder::edge_max && edge % 2 == 0; };
    if (!fits(width) || !fits(height) || pictures_per_s < 1 || pictures_per_s > pictures_per_s_max) {
        error = path + ": a film needs an even size of 16 to " + std::to_string(H264Encoder::edge_max) +
                " pixels (--size) and 1 to " + std::to_string(pictures_per_s_max) +
                " pictures per second (--fps)";
        return false;
    }
    try {
        encoder_ = std::make_unique<H264Encoder>(width, height, pictures_per_s);
        file_ = std::make_unique<Mp4File>(path);
        return true;
    } catch (const std::exception &failed) {
        return fail(failed, error);
    }
}

bool VideoWriter::add(const Image &image, std::string &error)
{
    if (!is_open()) {
        error = path_ + ": the film is not open";
        return false;
    }
    try {
        const std::size_t bytes =
            std::size_t{3} * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
        if (image.width != width_ || image.height != height_ || image.channels != 3 ||
            image.bytes.size() != bytes)
            throw std::runtime_error("a picture has another size than the film");
        const H264Encoder::Picture picture = encoder_->encode(image);
        file_->add(picture.bytes, picture.is_key);
        return true;
    } catch (const std::exception &failed) {
        return fail(failed, error);
    }
}

bool VideoWriter::finish(std::string &error)
{
    if (!is_open()) {
        error = path_ + ": the film is not open";
        return false;
    }
    try {
        file_->commit({width_, height_, pictures_per_s_, encoder_->sequence_parameters(),
                       encoder_->picture_parameters()});
    } catch (const std::exception &failed) {
        return fail(failed, error);
    }
    stop();
    return true;
}

// The message of an OutputError already contains the name of the file. The unfinished file is removed.
bool VideoWriter::fail(const std::exception &failed, std::string &error)
{
    error = dynamic_cast<const OutputError *>(&failed) ? failed.what() : path_ + ": " + failed.what();
    stop();
    return false;
}

void VideoWriter::stop()
{
    file_.reset();
    encoder_.reset();
}

} // namespace crn
