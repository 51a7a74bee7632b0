// cournand patient: makes a playable scene of a patient's own CT, by the program `ct` (docs/own_ct.md), or of
// vessel meshes and label maps, by `centreline` and `ct` (docs/own_mesh.md).
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

    std::vector<std::string> meshes;
    // Options for meshes and label maps with their values, as they are passed on.
    std::vector<std::pair<std::string, std::vector<std::string>>> choices;
};

void add_patient(CLI::App &app, PatientCommandOptions &options);

// Returns the words of the command that carries out `cournand patient new` or, for a folder that this command
// has made, `cournand patient review`: `centreline patient` for meshes, `ct labels` for a label map without a
// scan, and `ct patient` for a scan. `program` is the path of that program.
std::vector<std::string> patient_words(const std::string &program, const PatientCommandOptions &options,
                                       bool is_review, bool has_display);

// Becomes that program. Throws std::runtime_error if it is not there, and UsageError if what was stated fits
// no single input.
int command_patient(const CLI::App &app, const PatientCommandOptions &options);

} // namespace crn
