// Unpacks the compressed archive of a scene that comes with the program.
#pragma once
#include <filesystem>

namespace crn
{

// Writes the files of the archive, a tar file compressed by xz, into the folder, which is made. Either all
// files appear, together with the folder, or none does; two programs may unpack into the same folder at once.
// A terminal shows the progress. Throws std::runtime_error with the cause and the remedy.
void unpack_scene(const std::filesystem::path &archive, const std::filesystem::path &folder);

} // namespace crn
