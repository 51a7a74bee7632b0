// cournand dicom-check, and the options of `run` and `replay` that export DICOM.
#pragma once
#include "host/picture/dicom_export.hpp"
#include <CLI/CLI.hpp>

namespace crn
{

struct DicomCheckOptions {
    std::vector<std::string> files; // or folders
    bool shows_warnings = false;
};

void add_dicom_options(CLI::App &command, DicomSettings &settings);
void add_dicom_check(CLI::App &app, DicomCheckOptions &options);

// Returns 0 when the checked files have no errors. Returns 1 when a checked file has errors, or when a file
// cannot be read or the program dciodvfy cannot be run.
int command_dicom_check(const DicomCheckOptions &options);

} // namespace crn
