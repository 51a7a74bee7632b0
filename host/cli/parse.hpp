// Parses the command line in the same way for all programs of this project. Help texts, messages about the
// user's mistakes, man pages and completion all come from one table of commands and options.
#pragma once
#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

// Returns the names that the user may give instead of a file in an option whose values have this type, such
// as "INSTRUMENT". The list of names is empty if values of this type have no names.
using NamesOfType = std::function<std::vector<std::string>(const std::string &type)>;

// Parses the command line. Returns the exit code if the program must end now: 0 after a help text, the
// version or a generated text, and 2 after wrong usage. After wrong usage, this function prints the reason on
// stderr. Returns nothing if the program must carry out the command.
//
// `app` must already have its name and all its options and commands. Two hidden options are not in the table;
// each of them may only be the first word of a command line. `--generate KIND` writes man pages and
// completion scripts (generate.hpp), and `--complete WORDS` lists the words that may follow (complete.hpp).
// The completion scripts call the program with `--complete`.
std::optional<int> parse_command_line(CLI::App &app, int argc, char **argv, const NamesOfType &names = {});

// Finds the first word that is neither a command nor an option of the program, and returns an explanation
// with a suggestion. The returned explanation is empty if every word is known. `app` must have parsed the
// command line already, even if the parsing failed.
std::string unknown_word(const CLI::App &app);

} // namespace crn
