// Lists the words that may follow on a command line, for the completion of a shell.
#pragma once
#include "host/cli/parse.hpp"

namespace crn
{

// Holds a word that may stand at the end of a command line, and the explanation of this word.
struct Candidate {
    std::string word, text;
};
// States which paths a shell may offer in addition to the candidates.
enum class PathKind { none, files, folders };
struct Completion {
    std::vector<Candidate> candidates;
    PathKind paths = PathKind::none;
};

// `words` are the words after the program's name; the last one is the unfinished word, which may be empty.
// Only words that begin with the unfinished word are returned.
Completion completion_of(const CLI::App &app, const std::vector<std::string> &words,
                         const NamesOfType &names);

// Prints the possible completions of words[1] and the following words (words[0] is `--complete`). Each
// candidate has a line: the word, a tab and its explanation. The last line is ":none", ":files" or
// ":folders". Returns 0.
int complete(const CLI::App &app, const std::vector<std::string> &words, const NamesOfType &names);

} // namespace crn
