// The sub-commands of `ct`.
#pragma once
#include "tools/lab/ct/scanner.hpp"
#include "tools/lab/ct/segment.hpp"
#include "tools/lab/reference_rod/truth.hpp"
#include <filesystem>
#include <string>
#include <vector>

namespace crn::ct
{

// Prints lines of progress on standard error; throws Fault after Ctrl-C.
Report terminal_report();

struct ScanOptions {
    ScannerSettings scanner;
    PhantomMaterials phantom;
    std::filesystem::path mesh, output;
    std::vector<std::filesystem::path> lines;
    std::string instrument, material = "steel";
    double radius_mm = 0.4445, bore_mm = 0;
    std::vector<double> box_mm; // six numbers, or none
};

// Makes one virtual CT scan of a phantom with instruments in it; each instrument follows a given curve.
// Throws Fault.
void command_scan(ScanOptions options);

struct SimulateOptions {
    ScannerSettings scanner;
    PhantomMaterials phantom;
    std::filesystem::path folder;
    std::string format = "nrrd";   // of the volumes: nrrd, nii.gz, mha, dicom
    reference::TruthRequest truth; // with an instrument, the case is made first, in this folder
};

// Makes a virtual scan at every depth of a case that has a truth/ folder, and writes the names of the scans
// into case.toml. Throws Fault, or any exception that the function reference::make_case throws.
void command_simulate(SimulateOptions options);

struct SegmentCommand {
    SegmentOptions options;
    std::filesystem::path input,
        output; // a scan or a case; the folder, empty: beside the case, or out/segmentation
};

// Throws Fault.
void command_segment(const SegmentCommand &command);

// Compares the centrelines and the lumen of a case with the case's truth; returns false if a distance is
// larger than permitted.
bool command_check(const std::filesystem::path &case_folder);

} // namespace crn::ct
