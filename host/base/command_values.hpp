// Checks the values of command-line options before the program uses any of them.
#pragma once
#include "host/base/examples.hpp"
#include <CLI/CLI.hpp>
#include <stdexcept>
#include <string>

namespace crn
{

// The value of the returned validator's option may be the name of a file that comes with the program, or of
// one of the user's own files. The validator replaces the name by the file's path. A name may end with
// ":preset".
inline CLI::Validator name_or_path(const ExampleKind &kind)
{
    CLI::Validator names;
    names.operation([kind](std::string &word) {
        try {
            word = named_path(kind, word);
            return std::string();
        } catch (const std::runtime_error &error) {
            return std::string(error.what());
        }
    });
    return names;
}

// A script in which a variable is empty produces `--json ""`, which does not mean that no file is wanted. An
// option of this command, or of one of its subcommands, whose value is empty is refused as wrong usage.
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
