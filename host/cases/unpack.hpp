// Unpacks the compressed archive of a scene that comes with the program.
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>

namespace crn
{

// Creates the folder and writes the files of the archive, a tar file compressed by xz, into it. Either all
// files appear, together with the folder, or none of them does; two programs may unpack into the same folder
// at once. `goes_on` receives two numbers: how many bytes of the archive were read, and how many it has. If
// `goes_on` returns false, nothing is unpacked. Throws a std::runtime_error that states the cause and the
// remedy.
using UnpackWatch = std::function<bool(std::size_t done, std::size_t total)>;
void unpack_scene(const std::filesystem::path &archive, const std::filesystem::path &folder,
                  const UnpackWatch &goes_on);

} // namespace crn
