// Defines the layout of help texts: options in groups, ranges and defaults in words, lines of at most 100
// characters.
#pragma once
#include <CLI/CLI.hpp>

namespace crn
{

// Formats the help texts of a program and all its commands in the project's layout.
void use_help_format(CLI::App &app);

} // namespace crn
