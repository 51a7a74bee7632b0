// Reads and writes PNG files with libpng's simplified interface.
#include "host/base/pending_file.hpp"
#include "host/picture/picture.hpp"
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <png.h>
#include <stdexcept>

namespace crn
{

namespace
{

png_image image_head(int width, int height, png_uint_32 format)
{
    png_image png;
    std::memset(&png, 0, sizeof png);
    png.version = PNG_IMAGE_VERSION;
    png.width = static_cast<png_uint_32>(width);
    png.height = static_cast<png_uint_32>(height);
    png.format = format;
    return png;
}

bool write_any(const std::string &path, int width, int height, png_uint_32 format, const void *pixels,
               std::string &error)
{
    png_image png = image_head(width, height, format);
    try {
        PendingFile file(path);
        errno = 0;
        if (!png_image_write_to_stdio(&png, file.stream(), 0, pixels, 0, nullptr)) {
            if (errno != 0) throw OutputError(path, errno);
            throw OutputError(path + ": cannot be written: " + png.message);
        }
        file.commit();
        return true;
    } catch (const OutputError &refused) {
        error = refused.what();
        return false;
    }
}

png_uint_32 format_of(const Image &image)
{
    return image.channels == 3 ? PNG_FORMAT_RGB : PNG_FORMAT_GRAY;
}

} // namespace

bool write_png(const std::string &path, const Image &image, std::string &error)
{
    return write_any(path, image.width, image.height, format_of(image), image.bytes.data(), error);
}

std::vector<std::uint8_t> encode_png(const Image &image)
{
    png_image png = image_head(image.width, image.height, format_of(image));
    const auto write = [&](void *memory, png_alloc_size_t &size) {
        if (image.bytes.empty() ||
            !png_image_write_to_memory(&png, memory, &size, 0, image.bytes.data(), 0, nullptr))
            throw std::runtime_error(std::string("a picture cannot be encoded: ") + png.message);
    };
    png_alloc_size_t size = 0;
    write(nullptr, size);
    std::vector<std::uint8_t> bytes(size);
    write(bytes.data(), size);
    bytes.resize(size);
    return bytes;
}

Image read_grey_png(const std::string &path)
{
    constexpr png_uint_32 edge_max = 8192;
    png_image png = image_head(0, 0, PNG_FORMAT_GRAY);
    const auto fail = [&](const std::string &why) {
        png_image_free(&png);
        throw std::runtime_error(path + ": the picture cannot be read: " + why);
    };
    if (!png_image_begin_read_from_file(&png, path.c_str())) fail(png.message);
    if (png.width > edge_max || png.height > edge_max) fail("it has more than 8192 pixels along an edge");
    png.format = PNG_FORMAT_GRAY;
    Image image{static_cast<int>(png.width), static_cast<int>(png.height), 1, {}};
    image.bytes.resize(PNG_IMAGE_SIZE(png));
    const png_color black{0, 0, 0};
    if (!png_image_finish_read(&png, &black, image.bytes.data(), 0, nullptr)) fail(png.message);
    return image;
}

// The library libpng assumes that 16-bit values are linear in the intensity of light. The 16-bit values are
// stored unchanged, and the file states a gamma of 1.0.
bool write_png16(const std::string &path, int width, int height, const std::vector<std::uint16_t> &values,
                 std::string &error)
{
    return write_any(path, width, height, PNG_FORMAT_LINEAR_Y, values.data(), error);
}

} // namespace crn
