// Converts an instrument file to the list of tubes that the virtual scanner needs.
#pragma once
#include "tools/lab/ct/scanner.hpp"

namespace crn::ct
{

// Divides an instrument into stretches of constant cross-section, from the tip onwards, by the knots and
// layers of the instrument file. Throws crn::FileError, Fault.
std::vector<ScanStretch> stretches_of(const std::string &instrument_path);

// Makes a round tube of one material. Throws Fault for an unknown material.
std::vector<ScanStretch> plain_stretch(double radius_mm, double bore_mm, const std::string &material);

} // namespace crn::ct
