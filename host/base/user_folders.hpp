// Provides the paths of the user's own folders for this project, by the XDG Base Directory Specification.
#pragma once
#include <filesystem>

namespace crn
{

// Each function returns the folder's path, whether the folder exists or not; the path is empty if the
// environment names no folder. A relative path in an XDG variable is invalid and is ignored, as the
// specification demands.

// The user's own files are in $XDG_DATA_HOME/cournand or ~/.local/share/cournand.
std::filesystem::path data_folder();
// Recordings that the programs keep are in $XDG_STATE_HOME/cournand or ~/.local/state/cournand.
std::filesystem::path state_folder();
// Files that the programs can make again are in $XDG_CACHE_HOME/cournand or ~/.cache/cournand.
std::filesystem::path cache_folder();

} // namespace crn
