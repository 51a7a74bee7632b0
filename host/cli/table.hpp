// Reads the table of a program's commands and options, which the library CLI11 holds, for help texts, man
// pages and completion.
#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace crn
{

// Returns the commands of a program, or the subcommands of a command, in the order of their definition.
std::vector<const CLI::App *> commands_of(const CLI::App &app);

// Returns the options (which begin with a dash) or the arguments (which do not), in the order of their
// definition.
std::vector<const CLI::Option *> shown_options(const CLI::App &app);
std::vector<const CLI::Option *> arguments_of(const CLI::App &app);

// "cournand rig selftest"
std::string whole_name(const CLI::App &app);

// Describes the values of an option. Flags have no values.
struct ValueText {
    std::string type;                 // "INSTRUMENT", "FILE", "N", "A|B" ...; empty for a flag
    std::vector<std::string> choices; // the only values that are accepted; empty: any
    std::string range;                // "64 to 2048", or empty
};
ValueText value_text(const CLI::Option &option);

// Returns the description with the range and the default of the values, such as
// "Pictures per second (1 to 60; default 15)".
std::string whole_description(const CLI::Option &option);

// Returns, for example, "-o,--output FILE", or "FILE..." for an argument without a dash.
std::string option_usage(const CLI::Option &option);

} // namespace crn
