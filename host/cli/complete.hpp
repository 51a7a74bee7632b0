// Lists the words that may follow on a command line, for the completion of a shell.
#pragma once
#include "host/cli/parse.hpp"

namespace crn
{

// A word that may stand at the end of a command line, and what it means.
struct Candidate {
    std::string word, text;
};
// Names what a shell may offer besides the candidates.
enum class PathKind { none, files, folders };
struct Completion {
    std::vector<Candidate> candidates;
    PathKind paths = PathKind::none;
};

// `words` are the words behind the program's name; the last one is the unfinished word, which may be empty.
// Only words that begin with the unfinished word are returned.
Completion completion_of(const CLI::App &app, const std::vector<std::string> &words,
                         const NamesOfType &names);

// Prints the completion of words[1] and the following words (words[0] is `--complete`). Each candidate has a
// line, with a tab before its text; the last line is ":none", ":files" or ":folders". Returns 0.
int complete(const CLI::App &app, const std::vector<std::string> &words, const NamesOfType &names);

} // namespace crn
