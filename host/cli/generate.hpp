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

// Returns a script by which the shell completes command lines of this program. The script calls the program
// itself (`PROGRAM --complete WORDS`), so it always offers what the program accepts. `shell` is "bash", "zsh"
// or "fish"; for any other word the function returns an empty text.
std::string completion_script(const std::string &program, const std::string &shell);

// Carries out `--generate WHAT [FOLDER]`, where words[0] is `--generate`. WHAT is bash, zsh or fish for a
// completion script on stdout. If WHAT is man, FOLDER receives the man pages of the program and all its
// commands. If WHAT is share, FOLDER receives the scripts and the pages as they are installed below
// PREFIX/share. Returns the exit code.
int generate(const CLI::App &app, const std::vector<std::string> &words);

} // namespace crn
