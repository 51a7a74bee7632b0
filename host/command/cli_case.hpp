// Implements the command `cournand case` with its subcommands list, play, score, new and check
// (docs/cases.md).
#pragma once
#include "host/command/view_options.hpp"
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace crn
{

struct CaseOptions {
    std::string name;               // of a case, or its file
    std::vector<std::string> names; // the same, for the check
    bool checks_all = false, plays = false, as_json = false;
    std::string recording; // of `score`
    std::string script;    // expert, clumsy or a file; empty: the window
    std::string folder;    // of `new`; empty: the user's own
    std::string table;     // document whose table `check --play` renews
    std::string cards;     // folder for the cards of `list`
    std::string record, json, score, png, card, mp4;
    int size = 512;
    bool quiet = false;
};

void add_case(CLI::App &app, CaseOptions &options);
// Carries out the subcommand that the user named on the command line. `run_window` may be empty.
int command_case(const CLI::App &app, const CaseOptions &options, const RunWindow &run_window);

} // namespace crn
