// Finds scenes and recordings by their names, as examples.hpp finds the other files.
#pragma once
#include "host/cases/recipe.hpp"
#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

namespace crn
{

// Returns the path of the scene that a word of the command line means: the word itself if it is empty or a
// path, otherwise the first of these files that exists:
//  - NAME.scene in the user's own folder of scenes ($XDG_DATA_HOME/cournand/scenes),
//  - out/NAME.scene below the current folder or below the repository, where `make` writes scenes,
//  - the scene `heart`, `lad_pci` or `renal_pci`. The programs `anatomy` and `bake` make it in one to three
//    minutes when it is first needed. It is kept in the user's cache, like the scenes of cases,
//  - the scene of this name that comes with the program. It is compressed; the first use unpacks it into
//    the user's cache ($XDG_CACHE_HOME/cournand/scenes), with its bodies.
// Throws std::runtime_error with a suggestion, or with the command that makes the scene.
std::string scene_path(const std::string &word);

// Makes the scene of a recipe, unless it is in the cache, and tells the progress on stderr: in one line that
// is rewritten on a terminal, otherwise one line per stage. `who` says what the scene is for. Ctrl-C ends it.
// Throws as prepare_scene() does.
PreparedScene prepare_told_scene(const Recipe &recipe, const std::string &who, bool is_quiet);

// Returns the path of the recording that a word means: `last` is the newest one that the programs have kept
// ($XDG_STATE_HOME/cournand), and another name is the name of a kept one. A path stays. Throws
// std::runtime_error with a suggestion.
std::string recording_path(const std::string &word);

// Returns the path of any file that a name means: an instrument, session, stent, scene or recording. A path
// stays. Throws std::runtime_error with a suggestion.
std::string any_path(const std::string &word);

// Returns the names that may stand for values of this type: INSTRUMENT, STENT, SESSION, SCENE, RECORDING,
// or NAME for any of them.
std::vector<std::string> names_of_type(const std::string &type);

// Returns the recordings in the user's state folder, from the oldest to the newest.
std::vector<std::filesystem::path> kept_recording_files();

inline constexpr std::size_t kept_recordings_max = 20;
// Returns a new path for a recording in the user's state folder, whose name is made of date and time. The
// oldest recordings there are deleted, so that at most kept_recordings_max remain with the new one. Throws
// UsageError if the folder cannot be made.
std::string kept_recording();

// These validators replace a name by a path. A scene is only checked here, because the program unpacks it
// later: after it has found the command line right.
CLI::Validator scene_name();
CLI::Validator recording_name();
CLI::Validator any_name();

} // namespace crn
