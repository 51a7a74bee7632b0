// The command `ct patient`: makes a playable scene from a patient's CT (docs/own_ct.md).
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace crn::ct
{

struct PatientOptions {
    std::filesystem::path scan, output;
    std::filesystem::path labels, names; // both empty: the arteries are found without a label map
    std::vector<std::string> clicks;     // added to clicks.toml
    bool is_check = false;               // only reads the inputs and reports what they lack
};

// Writes the scene, its parts and a report into the folder. Steps whose inputs have not changed are not
// repeated. Throws Fault, OutputError or UsageError.
void command_patient(const PatientOptions &options);

} // namespace crn::ct
