// Renews the generated part of a documentation page.
#pragma once
#include <string>

namespace crn::validate
{

// Replaces the text between the marks "<!-- begin: written by `make TARGET` -->" and "<!-- end -->" of a
// page. Throws std::runtime_error, and changes nothing, if the page lacks a mark.
void write_between_marks(const std::string &path, const std::string &target, const std::string &text);

} // namespace crn::validate
