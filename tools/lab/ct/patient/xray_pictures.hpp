// Shows the X-ray pictures of a patient's CT on the page of its report.
#pragma once
#include "tools/lab/ct/page.hpp"

namespace crn::ct
{

// Draws the CT beside the body file from the front and from two sides, with the vessels of its tree filled
// with contrast medium in one picture. Throws Fault or OutputError.
void show_xray(const std::filesystem::path &bodies, Page &page);

} // namespace crn::ct
