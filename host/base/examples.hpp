// Finds the example files that come with the program, and a user's own files of the same kinds, by their
// names.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace crn
{

// Describes a kind of file that a user can name: its folder, its name in the singular for messages, and the
// ending of its file names.
struct ExampleKind {
    const char *folder, *singular, *ending;
};
inline constexpr ExampleKind instrument_files{"instruments", "instrument", ".toml"};
inline constexpr ExampleKind stent_files{"stents", "stent", ".toml"};
inline constexpr ExampleKind session_files{"sessions", "session", ".session"};
inline constexpr ExampleKind scene_files{"scenes", "scene", ".scene"};
inline constexpr ExampleKind anatomy_files{"anatomies", "anatomy", ".toml"};
inline constexpr ExampleKind lesion_files{"lesions", "lesion", ".toml"};
inline constexpr ExampleKind case_files{"cases", "case", ".toml"};
inline constexpr ExampleKind scene_archives{"scenes", "scene", ".tar.xz"};

// Returns the existing folders with the files of this kind that come with the program, in the order in which
// they are searched. The files are in share/cournand/examples/KIND of the installed program, and in
// shared/examples/KIND of the repository. The program looks for each of these two folders in the four folders
// above its own folder, and for shared/examples/KIND also in the current folder.
std::vector<std::filesystem::path> shipped_folders(const ExampleKind &kind);

// Returns the user's own folder, $XDG_DATA_HOME/cournand/KIND or ~/.local/share/cournand/KIND, if it exists,
// and then shipped_folders().
std::vector<std::filesystem::path> example_folders(const ExampleKind &kind);

// Holds the result of a search for a file by its name. If the file was not found, `path` is empty, and
// `others` has the names of all files in the folders, sorted and without repetitions.
struct FileSearch {
    std::string path;
    std::vector<std::string> others;
};
// Searches the folders, in their order, for the file with this name and ending.
FileSearch search_file(const std::vector<std::filesystem::path> &folders, const std::string &name);

// Returns the path of the file with this name, which has no ending. Throws std::runtime_error with a
// suggestion if there is no such file.
std::string example_path(const ExampleKind &kind, const std::string &name);

// Returns the names of all files of this kind, sorted.
std::vector<std::string> example_names(const ExampleKind &kind);

// Returns true if a word of the command line is a path. A path is a word with a slash or a dot, or the path
// of an existing file or folder; ":preset" may follow.
bool is_path(const std::string &word);

// Returns the path to which a word of the command line refers. A word that is_path() stays. A word that is
// not a path is the name of a file of this kind; if ":preset" follows the name, it also follows the returned
// path. Throws as example_path.
std::string named_path(const ExampleKind &kind, const std::string &word);

} // namespace crn
