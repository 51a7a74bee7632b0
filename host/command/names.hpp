// Finds scenes and recordings by their names, in the way in which examples.hpp finds other files.
#pragma once
#include "host/cases/recipe.hpp"
#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

namespace crn
{

// Returns the path of the scene to which a word of the command line refers. An empty word or a path is
// returned unchanged. For any other word, the function returns the first existing file of the following list.
//    WORD.scene in the user's own folder of scenes ($XDG_DATA_HOME/cournand/scenes)
//    out/WORD.scene below the current folder or below the repository, where `make` writes scenes
//    the scene `heart`, `lad_pci` or `renal_pci`
//    the scene with this name that comes with the program
// The first use of the scene `heart`, `lad_pci` or `renal_pci` takes one to three minutes, in which the
// programs `anatomy` and `bake` make it. After its first use, the scene `heart`, `lad_pci` or `renal_pci` is
// kept in the user's cache, like the scenes of cases. A scene that comes with the program is compressed; the
// first use unpacks the scene and its bodies into the user's cache ($XDG_CACHE_HOME/cournand/scenes). Throws
// a std::runtime_error that contains a suggestion or the command that makes the scene.
std::string scene_path(const std::string &word);

// Makes the scene of a recipe, unless it is in the cache, and shows the progress on stderr. On a terminal the
// program rewrites one line; otherwise it prints one line per stage. `who` names the case or scene for the
// progress messages. Ctrl-C ends it. Throws as prepare_scene() does.
PreparedScene prepare_told_scene(const Recipe &recipe, const std::string &who, bool is_quiet);

// Returns the path of the recording to which a word refers. The word `last` means the newest recording that
// the programs have kept ($XDG_STATE_HOME/cournand), and any other word is the name of a kept recording. A
// path stays. Throws std::runtime_error with a suggestion.
std::string recording_path(const std::string &word);

// Returns the path of any file to which a name refers: an instrument, session, stent, scene or recording. A
// path stays. Throws std::runtime_error with a suggestion.
std::string any_path(const std::string &word);

// Returns the names that may stand for values of this type: INSTRUMENT, STENT, SESSION, SCENE, RECORDING,
// or NAME for any of them.
std::vector<std::string> names_of_type(const std::string &type);

// Returns the paths of the recordings in the user's state folder, from the oldest to the newest.
std::vector<std::filesystem::path> kept_recording_files();

inline constexpr std::size_t kept_recordings_max = 20;
// Returns the path for a new recording in the user's state folder; the file's name consists of date and time.
// The function first deletes the oldest recordings in this folder, so that at most kept_recordings_max
// remain, including the new one. Throws UsageError if the folder cannot be made.
std::string kept_recording();

// The following validators replace a name by a path. For the name of a scene, the validator only checks that
// the name is known. The program unpacks the scene later, when the whole command line is known to be right.
CLI::Validator scene_name();
CLI::Validator recording_name();
CLI::Validator any_name();

} // namespace crn
