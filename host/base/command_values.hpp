// Checks the values of command-line options before the program uses any of them.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

namespace crn
{

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
