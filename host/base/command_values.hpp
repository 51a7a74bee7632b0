// Checks the values of command-line options before the program uses any of them.
#pragma once
#include "host/base/examples.hpp"
#include "host/base/text.hpp"
#include <CLI/CLI.hpp>
#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

namespace crn
{

// The returned validator replaces each value of an option by the result of the function `replace`. If
// `replace` throws a std::runtime_error, the value is refused with the text of this exception.
template <typename Replace> CLI::Validator replaced_by(Replace replace)
{
    CLI::Validator values;
    values.operation([replace](std::string &word) {
        try {
            word = replace(word);
            return std::string();
        } catch (const std::runtime_error &error) {
            return std::string(error.what());
        }
    });
    return values;
}

// With the returned validator, the value of an option may be the name of a file that comes with the program,
// or of one of the user's own files. The validator replaces the name of such a file by the file's path. A
// name may end with ":preset".
inline CLI::Validator name_or_path(const ExampleKind &kind)
{
    return replaced_by([kind](const std::string &word) { return named_path(kind, word); });
}

// The returned validator accepts only the given words, and suggests one of them if the user mistyped a word.
inline CLI::Validator one_of(const std::vector<std::string> &words)
{
    std::string list;
    for (const std::string &word : words) list += (list.empty() ? "" : ",") + word;
    return CLI::Validator(
        [words](std::string &word) {
            if (std::find(words.begin(), words.end(), word) != words.end()) return std::string();
            return "there is no '" + word + "'" + suggestion(word, words);
        },
        "{" + list + "}");
}

// If a variable in a user's shell script is empty, the command line contains `--json ""`, although the user
// wants a file. An option of this command or of a subcommand may not have an empty value; an empty value is
// refused as wrong usage.
inline void refuse_empty_values(CLI::App &app)
{
    for (CLI::Option *option : app.get_options())
        if (option->get_expected_min() > 0)
            option->check([](const std::string &value) {
                return value.empty() ? std::string("is empty: give it a value, or leave the option out")
                                     : std::string();
            });
    for (CLI::App *command : app.get_subcommands({})) refuse_empty_values(*command);
}

} // namespace crn
