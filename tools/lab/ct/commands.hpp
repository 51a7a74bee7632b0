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

// Makes one volume of a phantom with instruments along lines. Throws Fault.
void command_scan(ScanOptions options);

struct SimulateOptions {
    ScannerSettings scanner;
    PhantomMaterials phantom;
    std::filesystem::path folder;
    std::string format = "nrrd";   // of the volumes: nrrd, nii.gz, mha, dicom
    reference::TruthRequest truth; // with an instrument, the case is made first, in this folder
};

// Scans every depth of a case that has a truth/ folder, and writes the scans' names into case.toml. Throws
// Fault, and any exception that reference::make_case throws.
void command_simulate(SimulateOptions options);

struct SegmentCommand {
    SegmentOptions options;
    std::filesystem::path input,
        output; // a scan or a case; the folder, empty: beside the case, or out/segmentation
};

// Throws Fault.
void command_segment(const SegmentCommand &command);

// Compares a case's centrelines and lumen with its truth; returns false if a distance is over its bar.
bool command_check(const std::filesystem::path &case_folder);

} // namespace crn::ct
