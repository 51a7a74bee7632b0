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

// 0: no errors; 1: errors, or a file or the program dciodvfy that cannot be run.
int command_dicom_check(const DicomCheckOptions &options);

} // namespace crn
