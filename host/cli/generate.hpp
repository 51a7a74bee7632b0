// Writes man pages and completion scripts from a program's table of commands and options.
#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace crn
{

// Returns the man page (section 1) of a program or of one of its commands, in the macros of man(7).
std::string man_page(const CLI::App &app);
// "cournand-rig-selftest.1"
std::string man_file(const CLI::App &app);

// Returns a script that completes command lines of this program in the shell. The script calls the program
// itself (`PROGRAM --complete WORDS`), so it never disagrees with the program. `shell` is "bash", "zsh" or
// "fish"; for another word the text is empty.
std::string completion_script(const std::string &program, const std::string &shell);

// Carries out `--generate WHAT [FOLDER]`, where words[0] is `--generate`. WHAT is bash, zsh or fish, for a
// script on stdout; man, for the pages of the program and all its commands in FOLDER; or share, for all of
// them below FOLDER as they are installed below PREFIX/share. Returns the exit code.
int generate(const CLI::App &app, const std::vector<std::string> &words);

} // namespace crn
