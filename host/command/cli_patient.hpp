// cournand patient: makes a playable scene of a patient's own CT, by the program `ct` (docs/own_ct.md).
#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace crn
{

struct PatientCommandOptions {
    std::string scan, labels, names, folder;
    std::vector<std::string> clicks;
    bool shows_window = true;
};

void add_patient(CLI::App &app, PatientCommandOptions &options);

// Returns the words of the command `ct patient` that carries out `cournand patient new` or, for a folder that
// this command has made, `cournand patient review`.
std::vector<std::string> patient_words(const std::string &ct, const PatientCommandOptions &options,
                                       bool is_review, bool has_display);

// Becomes the program `ct`. Throws std::runtime_error if it is not there.
int command_patient(const CLI::App &app, const PatientCommandOptions &options);

} // namespace crn
