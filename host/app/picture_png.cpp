// PNG by libpng's simplified interface.
#include "host/app/picture.hpp"
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <png.h>
#include <unistd.h>

namespace seld
{

bool write_png(const std::string &path, const Image &image, std::string &error)
{
    png_image png;
    std::memset(&png, 0, sizeof png);
    png.version = PNG_IMAGE_VERSION;
    png.width = static_cast<png_uint_32>(image.width);
    png.height = static_cast<png_uint_32>(image.height);
    png.format = image.channels == 3 ? PNG_FORMAT_RGB : PNG_FORMAT_GRAY;
    const std::string unfinished = path + ".part" + std::to_string(::getpid());
    errno = 0;
    if (!png_image_write_to_file(&png, unfinished.c_str(), 0, image.bytes.data(), 0, nullptr)) {
        error = path + ": cannot write the picture: " + (errno ? std::strerror(errno) : png.message) +
                "; check that the folder exists and the disk has room";
        ::unlink(unfinished.c_str());
        return false;
    }
    if (std::rename(unfinished.c_str(), path.c_str()) == 0) return true;
    error = path + ": cannot give the finished picture its name: " + std::strerror(errno);
    ::unlink(unfinished.c_str());
    return false;
}

} // namespace seld
