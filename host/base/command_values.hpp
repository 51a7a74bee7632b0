// Checks the values of options on a command line before any of them is used.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

namespace crn
{

// `--json ""` comes from a script's empty variable and does not mean "no file": it is wrong usage, here and
// in every command below.
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
