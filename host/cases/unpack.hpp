// Unpacks the compressed archive of a scene that comes with the program.
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>

namespace crn
{

// Writes the files of the archive, a tar file compressed by xz, into the folder, which is made. Either all
// files appear, together with the folder, or none does; two programs may unpack into the same folder at once.
// `goes_on` receives the bytes of the archive that were read, and all of them; if it returns false, nothing
// is unpacked. Throws std::runtime_error with the cause and the remedy.
using UnpackWatch = std::function<bool(std::size_t done, std::size_t total)>;
void unpack_scene(const std::filesystem::path &archive, const std::filesystem::path &folder,
                  const UnpackWatch &goes_on);

} // namespace crn
