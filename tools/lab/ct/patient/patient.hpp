// The command `ct patient`: makes a playable scene from a patient's CT (docs/own_ct.md).
#pragma once
#include <filesystem>

namespace crn::ct
{

struct PatientOptions {
    std::filesystem::path scan, labels, names, output;
    bool is_check = false; // only reads the inputs and reports what they lack; labels may be missing
};

// Writes the scene, its parts and a report into the folder. Steps whose inputs have not changed are not
// repeated. Throws Fault, OutputError or UsageError.
void command_patient(const PatientOptions &options);

} // namespace crn::ct
