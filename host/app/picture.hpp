// Pictures as files: PNG, and MP4 through the ffmpeg program.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace seld
{

// 8-bit grey or RGB, row 0 on top.
struct Image {
    int width = 0;
    int height = 0;
    int channels = 1; // 1 or 3
    std::vector<std::uint8_t> bytes;
};

// Writes beside the wanted name and renames at the end, so that no half file appears under it.
// False with a message that names the file and the cause.
bool write_png(const std::string &path, const Image &image, std::string &error);

} // namespace seld
