// Parses the command line of a program in the same way for all programs of this project: help, mistakes in
// the user's words, man pages and completion all come from the same table of commands and options.
#pragma once
#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

// Returns the names that may stand in place of a file in an option whose values have this type, such as
// "INSTRUMENT". The list is empty for a type whose values have no names.
using NamesOfType = std::function<std::vector<std::string>(const std::string &type)>;

// Parses the command line. Returns the exit code if the program must end now: 0 after a help text, the
// version or a generated text, or 2 after wrong usage, which this function explains on stderr. Returns
// nothing if the program must carry out the command.
//
// `app` must have a name and all its options and commands. Two hidden first words are not in the table:
// `--generate KIND` writes man pages and completion scripts (generate.hpp), and `--complete WORDS` lists what
// may follow (complete.hpp). The completion scripts call the second one.
std::optional<int> parse_command_line(CLI::App &app, int argc, char **argv, const NamesOfType &names = {});

// Returns an explanation of the first word that is no command and no option of the program, with a
// suggestion. The text is empty if every word is known. `app` must have parsed the command line, even if this
// failed.
std::string unknown_word(const CLI::App &app);

} // namespace crn
